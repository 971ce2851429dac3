// SPDX-License-Identifier: Apache-2.0
#include "firmware/transmit/spill.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstring>
#include <map>
#include <tuple>

#include "proto/check.hpp"
#include "proto/envelope.hpp"

namespace srd::firmware {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kHeadBytes = 4096;
constexpr std::uint64_t kHeadWord = 0x3130'6C6C'6970'7353;  // "Sspill01"
constexpr std::uint64_t kCellWord = 0x3130'6C6C'6563'7353;  // "Sscell01"
constexpr std::size_t kRound = 64;
constexpr const char* kEnding = ".spill";

void put_number(std::span<std::uint8_t> to, std::size_t at, std::uint64_t value) {
  for (std::size_t i = 0; i < 8; ++i) to[at + i] = static_cast<std::uint8_t>(value >> (8 * i));
}

std::uint64_t number_at(std::span<const std::uint8_t> from, std::size_t at) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < 8; ++i) value |= std::uint64_t{from[at + i]} << (8 * i);
  return value;
}

// Head: word, check of the rest, boot, generation, oldest, bytes of a cell, node's name and its length, lost ranges
// and how many.
constexpr std::size_t kLostAt = 8 * 7 + 32;
constexpr std::size_t kHeadUsed = kLostAt + 8 + 16 * LostRanges::kCapacity;
static_assert(kHeadUsed <= 512, "a disk writes so much at once, or nothing of it");
// Cell: word, check of the rest, boot, sequence, bytes; the encoded frame.
constexpr std::size_t kCellUsed = 8 * 5;

void seal_block(std::span<std::uint8_t> block, std::uint64_t word) {
  put_number(block, 0, word);
  put_number(block, 8, proto::crc32c(0, block.subspan(16)));
}

bool holds(std::span<const std::uint8_t> block, std::uint64_t word) {
  return number_at(block, 0) == word && number_at(block, 8) == proto::crc32c(0, block.subspan(16));
}

Problem spill_problem(const char* action, const fs::path& path, int error) {
  return {Exit::kInput,
          std::string("cannot ") + action + " the spill: " + std::strerror(error),
          path.string(),
          "",
          "",
          error == ENOSPC ? "room there, or fewer node.ring_frames" : "a folder that the node's user may write"};
}

}  // namespace

SpillFile::SpillFile(const SpillOptions& options, fs::path file, UniqueFd fd, const proto::BootId& of, std::uint64_t generation)
    : file_(std::move(file)),
      fd_(std::move(fd)),
      of_(of),
      generation_(generation),
      frames_(options.frames),
      cell_bytes_((kCellUsed + options.frame_bytes + kRound - 1) / kRound * kRound),
      sync_interval_(options.sync_interval),
      free_((options.frames + 63) / 64, ~std::uint64_t{0}),
      cell_of_(options.frames, kNoCell),
      cell_(cell_bytes_) {
  if (options.frames % 64 != 0) free_.back() = (std::uint64_t{1} << (options.frames % 64)) - 1;
  thread_ = std::thread([this] { sync_when_asked(); });
}

Outcome<std::unique_ptr<SpillFile>> SpillFile::create(const SpillOptions& options, const proto::BootId& of,
                                                      std::uint64_t generation) {
  std::error_code error;
  fs::create_directories(options.folder, error);
  if (error) return spill_problem("make", options.folder, error.value());
  std::array<char, 24> boot{};
  (void)std::snprintf(boot.data(), boot.size(), "%016llx", static_cast<unsigned long long>(of.boot));
  const fs::path file = options.folder / (std::string(of.node.view()) + "-" + boot.data() + kEnding);
  UniqueFd fd(::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0640));
  // Held as long as this process lives: its file is no other's.
  if (!fd.valid() || ::flock(fd.get(), LOCK_EX | LOCK_NB) != 0) return spill_problem("make", file, errno);
  const std::size_t cell = (kCellUsed + options.frame_bytes + kRound - 1) / kRound * kRound;
  if (const int full = ::posix_fallocate(fd.get(), 0, static_cast<off_t>(kHeadBytes + options.frames * cell)); full != 0) {
    (void)::unlink(file.c_str());
    return spill_problem("make", file, full);
  }
  std::unique_ptr<SpillFile> made(new SpillFile(options, file, std::move(fd), of, generation));
  made->write_head();
  if (made->error_ != 0 || ::fsync(made->fd_.get()) != 0)
    return spill_problem("write", file, made->error_ != 0 ? made->error_.load() : errno);
  const UniqueFd entry(::open(options.folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (entry.valid()) (void)::fsync(entry.get());
  return made;
}

SpillFile::~SpillFile() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void SpillFile::remove() { (void)::unlink(file_.c_str()); }

void SpillFile::write(std::uint64_t offset, std::span<const std::uint8_t> bytes, bool frame) {
  while (!bytes.empty()) {
    const ssize_t written = ::pwrite(fd_.get(), bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      error_ = written < 0 ? errno : EIO;
      counts_.failed += frame ? 1 : 0;
      return;
    }
    offset += static_cast<std::uint64_t>(written);
    counts_.written_bytes += static_cast<std::uint64_t>(written);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  counts_.written += frame ? 1 : 0;
}

void SpillFile::write_head() {
  std::array<std::uint8_t, kHeadUsed> head{};
  put_number(head, 16, of_.boot);
  put_number(head, 24, generation_);
  put_number(head, 32, oldest_);
  put_number(head, 40, cell_bytes_);
  put_number(head, 48, of_.node.view().size());
  std::copy(of_.node.view().begin(), of_.node.view().end(), head.begin() + 56);
  put_number(head, kLostAt, lost_.size());
  for (std::size_t i = 0; i < lost_.size(); ++i) {
    put_number(head, kLostAt + 8 + 16 * i, lost_[i].begin);
    put_number(head, kLostAt + 16 + 16 * i, lost_[i].end);
  }
  seal_block(head, kHeadWord);
  write(0, head, false);
}

std::uint32_t SpillFile::take_cell() {
  for (; lowest_free_ < free_.size(); ++lowest_free_) {
    std::uint64_t& word = free_[lowest_free_];
    if (word == 0) continue;
    const int bit = std::countr_zero(word);
    word &= word - 1;
    return static_cast<std::uint32_t>(lowest_free_ * 64 + static_cast<std::size_t>(bit));
  }
  return kNoCell;
}

void SpillFile::give_cell(std::uint32_t cell) {
  free_[cell / 64] |= std::uint64_t{1} << (cell % 64);
  lowest_free_ = std::min<std::size_t>(lowest_free_, cell / 64);
}

void SpillFile::put(std::uint64_t sequence, std::span<const std::uint8_t> encoded) {
  next_ = sequence + 1;
  const std::uint32_t cell = kCellUsed + encoded.size() <= cell_bytes_ ? take_cell() : kNoCell;
  cell_of_[sequence % frames_] = cell;
  if (cell == kNoCell) {
    ++counts_.failed;
    return;
  }
  const auto bytes = std::span(cell_).first(kCellUsed + encoded.size());
  put_number(bytes, 16, of_.boot);
  put_number(bytes, 24, sequence);
  put_number(bytes, 32, encoded.size());
  std::copy(encoded.begin(), encoded.end(), bytes.begin() + kCellUsed);
  seal_block(bytes, kCellWord);
  write(kHeadBytes + std::uint64_t{cell} * cell_bytes_, bytes, true);
}

void SpillFile::release(std::uint64_t oldest, const LostRanges& lost) {
  if (oldest <= oldest_) return;
  for (std::uint64_t s = oldest_; s < oldest && s < next_; ++s) {
    std::uint32_t& cell = cell_of_[s % frames_];
    if (cell != kNoCell) give_cell(cell);
    cell = kNoCell;
  }
  oldest_ = oldest;
  lost_ = lost;
  if (unsynced_ < oldest_) {  // the host was quicker than the disk had to be
    unsynced_ = oldest_;
    unsynced_seen_ = false;
  }
  write_head();
}

void SpillFile::tick(std::int64_t now) {
  if (unsynced_ >= next_) return;
  if (!unsynced_seen_) unsynced_ns_ = now;
  unsynced_seen_ = true;
  if (now - unsynced_ns_ < sync_interval_) return;
  {
    const std::lock_guard lock(mutex_);
    if (asked_ || syncing_) return;
    asked_ = true;
  }
  wake_.notify_one();
  unsynced_ = next_;
  unsynced_seen_ = false;
}

void SpillFile::sync_when_asked() {
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return asked_ || ending_; });
    if (!asked_) return;
    asked_ = false;
    syncing_ = true;
    lock.unlock();
    if (::fdatasync(fd_.get()) != 0) sync_error_ = errno;
    ++syncs_;
    lock.lock();
    syncing_ = false;
  }
}

SpillCounts SpillFile::counts() const {
  SpillCounts out = counts_;
  out.syncs = syncs_;
  return out;
}

std::string SpillFile::problem() const {
  const int error = error_ != 0 ? error_.load() : sync_error_.load();
  return error == 0 ? std::string() : file_.string() + ": " + std::strerror(error);
}

Outcome<SpilledFrames> SpillFile::read(const fs::path& file) {
  const UniqueFd fd(::open(file.c_str(), O_RDONLY | O_CLOEXEC));
  struct stat info {};
  if (!fd.valid() || ::fstat(fd.get(), &info) != 0 || ::flock(fd.get(), LOCK_SH | LOCK_NB) != 0)
    return spill_problem("read", file, errno);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(info.st_size));
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t got = ::pread(fd.get(), bytes.data() + done, bytes.size() - done, static_cast<off_t>(done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return spill_problem("read", file, errno);
    if (got == 0) bytes.resize(done);
    done += static_cast<std::size_t>(got);
  }
  SpilledFrames out{.file = file, .of = {}};
  const bool head = bytes.size() >= kHeadUsed && holds(std::span(bytes).first(kHeadUsed), kHeadWord);
  if (head) {
    const std::size_t length = std::min<std::size_t>(number_at(bytes, 48), 32);
    const auto node = proto::NodeId::make({reinterpret_cast<const char*>(bytes.data()) + 56, length});
    if (node) out.of = {*node, number_at(bytes, 16)};
    out.generation = number_at(bytes, 24);
    out.oldest = number_at(bytes, 32);
    for (std::size_t i = 0; i < std::min<std::size_t>(number_at(bytes, kLostAt), LostRanges::kCapacity); ++i)
      out.lost.push({number_at(bytes, kLostAt + 8 + 16 * i), number_at(bytes, kLostAt + 16 + 16 * i)});
  }
  // Cells lie at multiples of kRound whatever their size: without the head they are found all the same.
  std::map<std::uint64_t, std::vector<std::uint8_t>> frames;
  for (std::size_t at = kHeadBytes; at + kCellUsed <= bytes.size(); at += kRound) {
    const auto cell = std::span(bytes).subspan(at);
    if (number_at(cell, 0) != kCellWord) continue;
    const std::uint64_t size = number_at(cell, 32), sequence = number_at(cell, 24);
    if (size > proto::kMaxDatagram || kCellUsed + size > cell.size() || sequence < out.oldest) continue;
    if (!holds(cell.first(kCellUsed + size), kCellWord)) continue;
    const auto encoded = cell.subspan(kCellUsed, size);
    const auto envelope = proto::read_envelope(encoded);
    if (!envelope || envelope->of.boot != number_at(cell, 16) || envelope->content != proto::Content::kFrame) continue;
    if (out.of.node.view().empty()) out.of = envelope->of;
    if (envelope->of == out.of) frames[sequence].assign(encoded.begin(), encoded.end());
  }
  for (auto& [sequence, encoded] : frames) out.frames.push_back({sequence, std::move(encoded)});
  if (!head && !out.frames.empty()) out.oldest = out.frames.front().sequence;
  return out;
}

std::vector<SpilledFrames> SpillFile::read_all(const fs::path& folder) {
  std::vector<SpilledFrames> out;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    if (entry.path().extension() != kEnding) continue;
    if (auto spilled = read(entry.path()); spilled.ok()) out.push_back(std::move(*spilled));
  }
  std::sort(out.begin(), out.end(),
            [](const auto& a, const auto& b) { return std::tie(a.generation, a.file) < std::tie(b.generation, b.file); });
  return out;
}

}  // namespace srd::firmware
