// SPDX-License-Identifier: Apache-2.0
// Receives, records, acknowledges: what srd listen does, without its socket. Frames go to the sink as soon as they are in
// order; the sink is flushed every few ms, and only then is anything acknowledged. One thread.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <vector>

#include "host/coefficients/frame_sink.hpp"
#include "host/listen/receiver.hpp"

namespace srd::host {

struct SessionOptions {
  std::map<proto::BootId, SequenceSet> in_file;  // what the sink has from before
  std::uint64_t session = 0;                     // random
  KeysOfNode keys{};                             // none: a link without keys
  std::uint64_t most_rows = std::numeric_limits<std::uint64_t>::max();
  // ns. At most a quarter of the time goes into flushing: after a slow flush the next one waits longer.
  std::int64_t flush_interval = 20'000'000;
  std::uint64_t flush_rows = 64;        // or as soon as so many rows are new
  std::function<std::int64_t()> clock;  // ns, steady
};

struct Answer {
  Address to;
  std::vector<std::uint8_t> datagram;
};

class Session {
 public:
  // sinks outlive the session; each frame goes to all of them.
  Session(SessionOptions options, std::vector<FrameSink*> sinks);

  void receive(std::span<const std::uint8_t> datagram, const Address& from);
  // Records what is ready; flushes and answers when it is time. Call at least every few ms.
  [[nodiscard]] Outcome<std::vector<Answer>> advance();
  // Records what is ready, flushes, and answers everyone. give_up: also what waits behind gaps that nobody fills now.
  [[nodiscard]] Outcome<std::vector<Answer>> finish(bool give_up);

  [[nodiscard]] std::uint64_t rows() const { return rows_; }
  [[nodiscard]] bool has_all_rows() const { return rows_ >= options_.most_rows; }
  // A frame waits for an earlier one that a node heard within the last time_ns may still send.
  [[nodiscard]] bool waits_for_a_gap(std::int64_t time_ns) const;
  [[nodiscard]] const Receiver& receiver() const { return receiver_; }
  // Height at the pattern's centre in the last row with a surface, mm; NaN before there is one.
  [[nodiscard]] double last_height_mm() const { return last_height_mm_; }

 private:
  [[nodiscard]] Outcome<void> record_ready();
  [[nodiscard]] Outcome<void> flush();
  [[nodiscard]] std::vector<Answer> answers(bool to_everyone);

  SessionOptions options_;
  std::vector<FrameSink*> sinks_;
  Receiver receiver_;
  std::uint64_t rows_ = 0, flushed_rows_ = 0;
  std::int64_t flushed_ns_ = 0, next_flush_ns_ = 0;
  double last_height_mm_ = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace srd::host
