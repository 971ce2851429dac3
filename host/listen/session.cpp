// SPDX-License-Identifier: Apache-2.0
#include "host/listen/session.hpp"

#include <algorithm>
#include <utility>

#include "host/coefficients/row_writer.hpp"

namespace srd::host {

Session::Session(SessionOptions options, std::vector<FrameSink*> sinks)
    : options_(std::move(options)),
      sinks_(std::move(sinks)),
      receiver_(std::exchange(options_.in_file, {}), options_.session, options_.keys) {}

void Session::receive(std::span<const std::uint8_t> datagram, const Address& from) {
  receiver_.receive(datagram, from, options_.clock());
}

Outcome<void> Session::record_ready() {
  while (!has_all_rows()) {
    const auto ready = receiver_.ready();
    if (!ready) break;
    for (FrameSink* sink : sinks_)
      if (auto done = sink->write(ready->from, ready->sequence, *ready->frame); !done) return done;
    if (ready->frame->has_surface()) last_height_mm_ = height_at_centre(*ready->frame);
    receiver_.pop_ready();
    ++rows_;
  }
  return {};
}

Outcome<void> Session::flush() {
  const std::int64_t start = options_.clock();
  for (FrameSink* sink : sinks_)
    if (auto done = sink->flush(); !done) return done;
  const std::int64_t end = options_.clock();
  flushed_rows_ = rows_;
  flushed_ns_ = end;
  next_flush_ns_ = std::max(start + options_.flush_interval, end + 3 * (end - start));
  return {};
}

std::vector<Answer> Session::answers(bool to_everyone) {
  std::vector<Answer> out;
  for (auto& [to, datagram] : receiver_.acknowledgements(to_everyone)) out.push_back({to, std::move(datagram)});
  return out;
}

Outcome<std::vector<Answer>> Session::advance() {
  const std::int64_t now = options_.clock();
  receiver_.tick(now);
  if (auto done = record_ready(); !done) return done.error();
  const bool many = rows_ - flushed_rows_ >= options_.flush_rows;
  const bool due = now >= next_flush_ns_ || (many && now - flushed_ns_ >= (next_flush_ns_ - flushed_ns_) / 8);
  std::vector<Answer> out;
  for (auto& [to, welcome] : receiver_.take_welcomes()) out.push_back({to, std::move(welcome)});
  if (!receiver_.answer_due() || !due) return out;
  if (auto done = flush(); !done) return done.error();
  for (Answer& answer : answers(false)) out.push_back(std::move(answer));
  return out;
}

Outcome<std::vector<Answer>> Session::finish(bool give_up) {
  if (auto done = record_ready(); !done) return done.error();
  if (give_up) {
    receiver_.give_up();
    if (auto done = record_ready(); !done) return done.error();
  }
  for (FrameSink* sink : sinks_)
    if (auto done = sink->finish(); !done) return done.error();
  if (auto done = flush(); !done) return done.error();
  return answers(true);
}

bool Session::waits_for_a_gap(std::int64_t time_ns) const {
  const std::int64_t now = options_.clock();
  for (const auto& [id, source] : receiver_.sources())
    if (source.stream.missing() > 0 && now - source.heard_ns <= time_ns) return true;
  return false;
}

}  // namespace srd::host
