// SPDX-License-Identifier: Apache-2.0
// What a person sees of a running srd listen: one line that is rewritten on a terminal, and a table at the end.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "host/listen/session.hpp"

namespace srd::host {

// "3 nodes  12345 frames  601/s  missing 2  lost 0  resent 31  duplicates 4  height 80.12 mm  61 C", the hottest
// board's, then the concerns of two nodes at most. rate_hz: rows a second.
[[nodiscard]] std::string status_line(const Session& session, double rate_hz);

// A line a boot: node, boot, rows, how it ended, what was lost and where; then what was rejected.
[[nodiscard]] std::string summary_table(const Session& session);

// Of a pair of Receiver::shared_ids().
[[nodiscard]] std::string shared_id_text(const Receiver& receiver, const std::pair<proto::BootId, proto::BootId>& boots);

// Of one of Receiver::concerns(): what to do about it. keys: the folder that srd listen was given; empty: none.
[[nodiscard]] std::string concern_text(const std::pair<proto::NodeId, LinkConcern>& concern, const std::string& keys);

// What a person should know of a node that measures: "throttled", "clock not synchronised", "restart 2 after: ..".
[[nodiscard]] std::vector<std::string> concerns(const proto::NodeStatus& status);

// "5", "10-19": as people count, the last one included. At most `most` ranges, then "..".
[[nodiscard]] std::string range_text(const std::vector<proto::SequenceRange>& ranges, std::size_t most);

}  // namespace srd::host
