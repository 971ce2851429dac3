// SPDX-License-Identifier: Apache-2.0
#include "host/listen/record_folder.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>

#include "drivers/support/text_file.hpp"
#include "proto/host_codec.hpp"
#include "proto/node_codec.hpp"

namespace srd::host {
namespace {

namespace fs = std::filesystem;

Problem record_problem(const char* action, const fs::path& path, int error) {
  return {Exit::kDevice, std::string("cannot ") + action + " the record: " + std::strerror(error), path.string(), "", "", ""};
}

// By number.
Outcome<std::map<std::uint64_t, fs::path>> segments_of(const fs::path& folder) {
  std::map<std::uint64_t, fs::path> out;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error))
    if (entry.path().extension() == ".mcap")
      if (const auto number = parse_number<std::uint64_t>(entry.path().stem().string())) out[*number] = entry.path();
  if (error) return Problem{Exit::kInput, "cannot read the record: " + error.message(), folder.string(), "", "", ""};
  return out;
}

Outcome<void> read_segment(const fs::path& file, const RecordFolder::Use& use) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return Problem{Exit::kInput, "cannot read the record", file.string(), "", "", ""};
  const std::vector<char> text{std::istreambuf_iterator<char>(stream), {}};
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  const auto whole = mcap::read(bytes, [&](const mcap::Message& message) {
    if (const auto said = proto::decode_node_message(message.data))
      if (const auto* frame = std::get_if<proto::CoefficientFrame>(&said->content))
        use(said->header.from, said->header.sequence, *frame);
  });
  // A run that died within the first bytes of its segment left none.
  constexpr std::size_t kMagicBytes = 8;
  if (!whole && bytes.size() >= kMagicBytes)
    return Problem{Exit::kInput, "not a segment of a record", file.string(), "MCAP", "something else", "another folder"};
  return {};
}

}  // namespace

Outcome<void> RecordFolder::read(const fs::path& folder, const Use& use) {
  const auto segments = segments_of(folder);
  if (!segments) return segments.error();
  for (const auto& [number, file] : *segments)
    if (auto done = read_segment(file, use); !done) return done;
  return {};
}

Outcome<std::unique_ptr<RecordFolder>> RecordFolder::open(const fs::path& folder, std::function<std::int64_t()> wall_clock,
                                                          std::uint64_t segment_bytes) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return record_problem("make", folder, error.value());
  std::unique_ptr<RecordFolder> made(new RecordFolder(folder, std::move(wall_clock), segment_bytes));
  const auto segments = segments_of(folder);
  if (!segments) return segments.error();
  if (!segments->empty()) made->next_segment_ = segments->rbegin()->first + 1;
  const auto done = read(folder, [&](const proto::BootId& from, std::uint64_t sequence, const proto::CoefficientFrame&) {
    made->in_file_[from].add(sequence);
  });
  if (!done) return done.error();
  return made;
}

RecordFolder::~RecordFolder() { (void)end_segment(); }

Outcome<void> RecordFolder::append(const std::string& bytes) {
  for (std::string_view rest = bytes; !rest.empty();) {
    const ssize_t written = ::write(fd_.get(), rest.data(), rest.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return record_problem("write", file_, errno);
    rest.remove_prefix(static_cast<std::size_t>(written));
  }
  bytes_ += bytes.size();
  return {};
}

Outcome<void> RecordFolder::begin_segment() {
  std::array<char, 32> name{};
  (void)std::snprintf(name.data(), name.size(), "%06llu.mcap", static_cast<unsigned long long>(next_segment_++));
  file_ = folder_ / name.data();
  fd_.reset(::open(file_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644));
  if (!fd_.valid()) return record_problem("make", file_, errno);
  // The name must outlive a power cut as the frames do.
  const UniqueFd entry(::open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (entry.valid()) (void)::fsync(entry.get());
  bytes_ = 0;
  channels_.clear();
  writer_ = std::make_unique<mcap::Writer>("srd.wire.NodeDatagram", proto::record_schema());
  return append(writer_->start());
}

Outcome<void> RecordFolder::end_segment() {
  if (!fd_.valid()) return {};
  if (auto done = append(writer_->take_chunk()); !done) return done;
  if (auto done = append(writer_->finish()); !done) return done;
  if (::fdatasync(fd_.get()) != 0) return record_problem("flush", file_, errno);
  fd_.reset();
  return {};
}

Outcome<void> RecordFolder::write(const proto::BootId& from, std::uint64_t sequence, const proto::CoefficientFrame& frame) {
  if (fd_.valid() && bytes_ >= segment_bytes_)
    if (auto done = end_segment(); !done) return done;
  if (!fd_.valid())
    if (auto done = begin_segment(); !done) return done;
  auto channel = channels_.find(from.node);
  if (channel == channels_.end()) {
    channel = channels_.emplace(from.node, static_cast<std::uint16_t>(channels_.size() + 1)).first;
    writer_->add_channel({channel->second, "/" + std::string(from.node.view())});
  }
  const auto now = static_cast<std::uint64_t>(std::max<std::int64_t>(0, wall_clock_()));
  const auto wall = static_cast<std::uint64_t>(std::max<std::int64_t>(0, frame.stamp.wall_time_ns));
  std::array<std::uint8_t, proto::kMaxEncoded> encoded;
  const auto bytes = proto::encode(from, sequence, frame, encoded);
  if (!bytes)  // none that a node sent
    return Problem{Exit::kDevice, "a frame breaks the bounds of proto/srd.proto", file_.string(), "", "", ""};
  writer_->add({.channel = channel->second,
                .sequence = static_cast<std::uint32_t>(sequence),
                .log_time_ns = now,
                .publish_time_ns = wall != 0 ? wall : now,
                .data = std::span(encoded).first(*bytes)});
  return {};
}

Outcome<void> RecordFolder::flush() {
  if (!fd_.valid()) return {};
  const std::string chunk = writer_->take_chunk();
  if (chunk.empty()) return {};
  if (auto done = append(chunk); !done) return done;
  if (::fdatasync(fd_.get()) != 0) return record_problem("flush", file_, errno);
  return {};
}

}  // namespace srd::host
