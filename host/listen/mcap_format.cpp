// SPDX-License-Identifier: Apache-2.0
#include "host/listen/mcap_format.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace srd::host::mcap {
namespace {

constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);
constexpr std::size_t kRecordHead = 9;  // opcode and length

enum Opcode : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0B,
  kDataEnd = 0x0F,
};

// CRC-32 (IEEE), as the format asks for.
constexpr std::array<std::uint32_t, 256> kCrc32Table = [] {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t c = i;
    for (int bit = 0; bit < 8; ++bit) c = (c >> 1) ^ ((c & 1) != 0 ? 0xEDB88320u : 0u);
    table[i] = c;
  }
  return table;
}();

template <class Bytes>
std::uint32_t crc32(const Bytes& bytes) {
  std::uint32_t crc = ~std::uint32_t{0};
  for (const auto byte : bytes) crc = (crc >> 8) ^ kCrc32Table[(crc ^ static_cast<std::uint8_t>(byte)) & 0xFF];
  return ~crc;
}

template <class T>
void put(std::string& out, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i) out += static_cast<char>(static_cast<std::uint64_t>(value) >> (8 * i));
}

void put_text(std::string& out, std::string_view text) {
  put(out, static_cast<std::uint32_t>(text.size()));
  out += text;
}

std::string record(Opcode opcode, std::string_view content) {
  std::string out(1, static_cast<char>(opcode));
  put(out, static_cast<std::uint64_t>(content.size()));
  out += content;
  return out;
}

// Reads numbers off the front; sound stays false once there was too little.
struct Bytes {
  std::span<const std::uint8_t> rest;
  bool sound = true;
  std::span<const std::uint8_t> take(std::uint64_t size) {
    sound = sound && size <= rest.size();
    if (!sound) return {};
    const auto taken = rest.first(static_cast<std::size_t>(size));
    rest = rest.subspan(taken.size());
    return taken;
  }
  template <class T>
  T number() {
    const auto bytes = take(sizeof(T));
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i) value |= std::uint64_t{bytes[i]} << (8 * i);
    return static_cast<T>(value);
  }
};

// The messages of a chunk that is whole.
bool read_chunk(std::span<const std::uint8_t> content, const std::function<void(const Message&)>& use) {
  Bytes chunk{content};
  chunk.take(16);
  const auto size = chunk.number<std::uint64_t>();
  const auto crc = chunk.number<std::uint32_t>();
  const auto compression = chunk.take(chunk.number<std::uint32_t>());
  const auto records = chunk.take(chunk.number<std::uint64_t>());
  if (!chunk.sound) return false;
  if (!compression.empty()) return true;
  if (size != records.size() || crc32(records) != crc) return false;
  for (Bytes at{records}; at.sound && !at.rest.empty();) {
    const auto opcode = at.number<std::uint8_t>();
    Bytes message{at.take(at.number<std::uint64_t>())};
    if (!at.sound || opcode != kMessage) continue;
    Message out;
    out.channel = message.number<std::uint16_t>();
    out.sequence = message.number<std::uint32_t>();
    out.log_time_ns = message.number<std::uint64_t>();
    out.publish_time_ns = message.number<std::uint64_t>();
    out.data = message.rest;
    if (message.sound) use(out);
  }
  return true;
}

}  // namespace

std::string Writer::schema_record() const {
  std::string content;
  put(content, std::uint16_t{1});
  put_text(content, schema_name_);
  put_text(content, "protobuf");
  put_text(content, descriptors_);
  return record(kSchema, content);
}

std::string Writer::channel_record(const Channel& channel) {
  std::string content;
  put(content, channel.id);
  put(content, std::uint16_t{1});
  put_text(content, channel.topic);
  put_text(content, "protobuf");
  put(content, std::uint32_t{0});  // no metadata
  return record(kChannel, content);
}

std::string Writer::start() {
  std::string header;
  put_text(header, "");
  put_text(header, "flume-srd");
  std::string out(kMagic);
  out += record(kHeader, header);
  out += schema_record();
  offset_ = out.size();
  return out;
}

// Schema and channels stand between chunks, before the first that needs them.
void Writer::add_channel(const Channel& channel) {
  channels_[channel.id] = channel;
  preface_ += channel_record(channel);
}

void Writer::add(const Message& message) {
  if (records_.empty()) begin_ns_ = end_ns_ = message.log_time_ns;
  auto& index = open_index_[message.channel];
  begin_ns_ = std::min(begin_ns_, message.log_time_ns);
  end_ns_ = std::max(end_ns_, message.log_time_ns);
  index.emplace_back(message.log_time_ns, records_.size());
  std::string content;
  put(content, message.channel);
  put(content, message.sequence);
  put(content, message.log_time_ns);
  put(content, message.publish_time_ns);
  content.append(reinterpret_cast<const char*>(message.data.data()), message.data.size());
  records_ += record(kMessage, content);
  ++message_counts_[message.channel];
}

std::string Writer::take_chunk() {
  if (records_.empty()) return {};
  std::string content;
  put(content, begin_ns_);
  put(content, end_ns_);
  put(content, static_cast<std::uint64_t>(records_.size()));
  put(content, crc32(records_));
  put_text(content, "");
  put(content, static_cast<std::uint64_t>(records_.size()));
  content += records_;
  std::string out = std::exchange(preface_, {});
  ChunkIndex chunk{.begin_ns = begin_ns_, .end_ns = end_ns_, .offset = offset_ + out.size(), .size = records_.size()};
  out += record(kChunk, content);
  chunk.bytes = offset_ + out.size() - chunk.offset;
  const std::size_t indexes = out.size();
  for (const auto& [channel, messages] : open_index_) {
    std::string index;
    put(index, channel);
    put(index, static_cast<std::uint32_t>(16 * messages.size()));
    for (const auto& [time, at] : messages) {
      put(index, time);
      put(index, at);
    }
    chunk.index_offsets[channel] = offset_ + out.size();
    out += record(kMessageIndex, index);
  }
  chunk.indexes_bytes = out.size() - indexes;
  chunks_.push_back(std::move(chunk));
  offset_ += out.size();
  records_.clear();
  open_index_.clear();
  return out;
}

void Writer::put_statistics(std::string& out) const {
  std::uint64_t messages = 0, begin = 0, end = 0;
  for (const auto& [channel, count] : message_counts_) messages += count;
  for (const ChunkIndex& chunk : chunks_) {
    begin = &chunk == &chunks_.front() ? chunk.begin_ns : std::min(begin, chunk.begin_ns);
    end = std::max(end, chunk.end_ns);
  }
  put(out, messages);
  put(out, std::uint16_t{1});  // schemas
  put(out, static_cast<std::uint32_t>(message_counts_.size()));
  put(out, std::uint32_t{0});  // attachments
  put(out, std::uint32_t{0});  // metadata
  put(out, static_cast<std::uint32_t>(chunks_.size()));
  put(out, begin);
  put(out, end);
  put(out, static_cast<std::uint32_t>(10 * message_counts_.size()));
  for (const auto& [channel, count] : message_counts_) {
    put(out, channel);
    put(out, count);
  }
}

std::string Writer::finish() {
  std::string data_end;
  put(data_end, std::uint32_t{0});  // not computed: each chunk has its own check
  std::string out = record(kDataEnd, data_end);
  const std::uint64_t summary = offset_ + out.size();
  out += schema_record();
  for (const auto& [id, count] : message_counts_) out += channel_record(channels_.at(id));
  std::string statistics;
  put_statistics(statistics);
  out += record(kStatistics, statistics);
  for (const ChunkIndex& chunk : chunks_) {
    std::string index;
    for (const std::uint64_t number : {chunk.begin_ns, chunk.end_ns, chunk.offset, chunk.bytes}) put(index, number);
    put(index, static_cast<std::uint32_t>(10 * chunk.index_offsets.size()));
    for (const auto& [channel, offset] : chunk.index_offsets) {
      put(index, channel);
      put(index, offset);
    }
    put(index, chunk.indexes_bytes);
    put_text(index, "");
    put(index, chunk.size);
    put(index, chunk.size);
    out += record(kChunkIndex, index);
  }
  std::string footer;
  put(footer, summary);
  put(footer, std::uint64_t{0});  // no summary offsets
  put(footer, std::uint32_t{0});  // not computed
  out += record(kFooter, footer);
  out += kMagic;
  offset_ += out.size();
  return out;
}

std::optional<std::size_t> read(std::span<const std::uint8_t> file, const std::function<void(const Message&)>& use) {
  if (file.size() < kMagic.size() || !std::equal(kMagic.begin(), kMagic.end(), file.begin(),
                                                 [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; }))
    return std::nullopt;
  std::size_t whole = kMagic.size();
  for (Bytes at{file.subspan(whole)}; at.rest.size() >= kRecordHead;) {
    const auto opcode = at.number<std::uint8_t>();
    const auto content = at.take(at.number<std::uint64_t>());
    if (!at.sound || (opcode == kChunk && !read_chunk(content, use))) break;
    whole = file.size() - at.rest.size();
    if (opcode == kDataEnd || opcode == kFooter) break;
  }
  return whole;
}

}  // namespace srd::host::mcap
