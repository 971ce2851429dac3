// SPDX-License-Identifier: Apache-2.0
// The part of the container format MCAP (https://mcap.dev/spec, version 0) that a record needs: a file of chunks with a check
// each, which whoever reads MCAP reads, and which are whole up to where a file was cut. No compression.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace srd::host::mcap {

struct Channel {
  std::uint16_t id = 0;
  std::string topic;
};

struct Message {
  std::uint16_t channel = 0;
  std::uint32_t sequence = 0;
  std::uint64_t log_time_ns = 0, publish_time_ns = 0;  // since 1970 UTC
  std::span<const std::uint8_t> data;
};

// Makes the bytes of one file, which the caller writes one after the other: start, chunks, finish.
class Writer {
 public:
  // All channels are of one schema: a message of protobuf by its full name, with its FileDescriptorSet.
  Writer(std::string schema_name, std::string descriptors)
      : schema_name_(std::move(schema_name)), descriptors_(std::move(descriptors)) {}

  [[nodiscard]] std::string start();
  // Before the first message of the channel; stays for the chunks after.
  void add_channel(const Channel& channel);
  // Into the chunk that is open.
  void add(const Message& message);
  [[nodiscard]] std::size_t pending_bytes() const { return records_.size(); }
  // The open chunk with its index; empty when there is no message in it.
  [[nodiscard]] std::string take_chunk();
  // Summary and end. After take_chunk.
  [[nodiscard]] std::string finish();

 private:
  struct ChunkIndex {
    std::uint64_t begin_ns = 0, end_ns = 0, offset = 0, bytes = 0, size = 0, indexes_bytes = 0;
    std::map<std::uint16_t, std::uint64_t> index_offsets{};
  };
  [[nodiscard]] std::string schema_record() const;
  [[nodiscard]] static std::string channel_record(const Channel& channel);
  void put_statistics(std::string& out) const;

  std::string schema_name_, descriptors_;
  std::map<std::uint16_t, Channel> channels_;
  std::map<std::uint16_t, std::uint64_t> message_counts_;
  std::string preface_;  // what stands before the open chunk
  std::string records_;  // of the open chunk
  std::map<std::uint16_t, std::vector<std::pair<std::uint64_t, std::uint64_t>>> open_index_;  // time, offset in the chunk
  std::uint64_t begin_ns_ = 0, end_ns_ = 0;                                                   // of the open chunk
  std::uint64_t offset_ = 0;                                                                  // in the file
  std::vector<ChunkIndex> chunks_;
};

// Calls use for each message of the file's whole chunks, in order, until the first that is not whole. Gives the bytes up to
// there; nullopt when the file does not begin as MCAP does. Messages outside of chunks, and compressed chunks, are passed over.
[[nodiscard]] std::optional<std::size_t> read(std::span<const std::uint8_t> file,
                                              const std::function<void(const Message&)>& use);

}  // namespace srd::host::mcap
