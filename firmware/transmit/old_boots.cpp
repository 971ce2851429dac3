// SPDX-License-Identifier: Apache-2.0
#include "firmware/transmit/old_boots.hpp"

#include <algorithm>

#include "proto/envelope.hpp"

namespace srd::firmware {
namespace {

constexpr std::uint32_t kWindow = 64;  // frames of one boot under way: the present boot's go first
constexpr int kGoodbyes = 3;

void forget(const std::filesystem::path& file) {
  std::error_code ignored;
  std::filesystem::remove(file, ignored);
}

}  // namespace

OldBoots::OldBoots(std::vector<SpilledFrames> spilled, const SenderOptions& as) {
  std::erase_if(spilled, [&](const SpilledFrames& boot) {
    if (boot.of.node != as.from.node) return !boot.of.node.view().empty();
    if (boot.frames.empty()) forget(boot.file);
    return boot.frames.empty();
  });
  std::uint64_t frames = 0, given_up = 0;
  for (std::size_t i = 0; i < spilled.size(); ++i) {
    const SpilledFrames& boot = spilled[i];
    if (i + kMost < spilled.size()) {
      given_up += boot.frames.size();
      forget(boot.file);
      continue;
    }
    SenderOptions options = as;
    options.from = boot.of;
    options.window = kWindow;
    options.ring_bytes = proto::kMaxEncoded;
    for (const auto& frame : boot.frames) options.ring_bytes += frame.encoded.size();
    options.ring_frames = static_cast<std::size_t>(boot.end() - boot.frames.front().sequence) + 1;
    auto sender = std::make_unique<Sender>(options);
    sender->restore(boot);
    frames += boot.frames.size();
    boots_.push_back({boot.file, boot.of, std::move(sender)});
  }
  if (!boots_.empty())
    summary_ = std::to_string(frames) + " frames of " + std::to_string(boots_.size()) +
               (boots_.size() == 1 ? " earlier run" : " earlier runs") + " are delivered first to last";
  if (given_up > 0) summary_ += "; " + std::to_string(given_up) + " frames of still earlier ones are given up";
}

std::span<const std::uint8_t> OldBoots::next(std::int64_t now) {
  for (std::size_t tried = 0; tried < boots_.size(); ++tried) {
    turn_ = turn_ + 1 < boots_.size() ? turn_ + 1 : 0;
    Boot& boot = boots_[turn_];
    if (boot.sender->unacknowledged() > 0) {
      if (const auto due = boot.sender->next(now); !due.empty()) return due;
    } else if (boot.goodbyes < kGoodbyes) {
      if (boot.goodbyes++ == 0) forget(boot.file);
      boot.sender->stop(now);
      if (const auto goodbye = boot.sender->status(now); !goodbye.empty()) return goodbye;
    }
  }
  std::erase_if(boots_, [](const Boot& boot) { return boot.goodbyes >= kGoodbyes; });
  return {};
}

bool OldBoots::receive(std::span<const std::uint8_t> datagram, std::int64_t now) {
  if (boots_.empty()) return false;
  const auto envelope = proto::read_envelope(datagram);
  if (!envelope) return false;
  for (Boot& boot : boots_)
    if (boot.id == envelope->of) {
      boot.sender->receive(datagram, now);
      return true;
    }
  return false;
}

std::uint64_t OldBoots::unacknowledged() const {
  std::uint64_t sum = 0;
  for (const Boot& boot : boots_) sum += boot.sender->unacknowledged();
  return sum;
}

}  // namespace srd::firmware
