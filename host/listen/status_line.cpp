// SPDX-License-Identifier: Apache-2.0
#include "host/listen/status_line.hpp"

#include <array>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "drivers/support/formatted.hpp"
#include "host/coefficients/columns.hpp"

namespace srd::host {
namespace {

const char* ending_of(const Source& source) {
  if (source.ended && source.stream.missing() == 0) return "ended";
  if (source.has_status) return proto::to_string(source.status.state);
  return "";
}

std::string joined(const std::vector<std::string>& parts) {
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : ", ") + part;
  return text;
}

// The boots that nodes are in now: of each node the last one that was heard of, unless it has ended.
std::vector<std::pair<proto::NodeId, const Source*>> present(const Receiver& receiver) {
  std::map<proto::NodeId, const Source*> latest;
  for (const auto& [id, source] : receiver.sources()) {
    const Source*& known = latest[id.node];
    if (known == nullptr || known->is_past() || (!source.is_past() && source.order > known->order)) known = &source;
  }
  std::vector<std::pair<proto::NodeId, const Source*>> out;
  for (const auto& [node, source] : latest)
    if (source->has_status && !source->ended) out.emplace_back(node, source);
  return out;
}

}  // namespace

std::vector<std::string> concerns(const proto::NodeStatus& status) {
  std::vector<std::string> out;
  if ((status.throttled & proto::Throttled::kNow) != 0)
    out.emplace_back(proto::throttled_text(status.throttled));
  else if (status.throttled != 0)
    out.push_back(std::string("was once ") + proto::throttled_text(status.throttled >> proto::Throttled::kEverShift));
  if (status.clock_state == proto::ClockState::kUnsynchronised) out.emplace_back("clock not synchronised");
  if (status.recording == proto::RecordState::kStopped) out.emplace_back("recording stopped");
  if (status.bad_stamps > 0)
    out.push_back(std::to_string(status.bad_stamps) +
                  " frames timed by their arrival: the camera's driver gave impossible times");
  if (status.disconnects > 0) out.push_back("camera was away " + std::to_string(status.disconnects) + " times");
  if (status.restarts > 0)
    out.push_back("restart " + std::to_string(status.restarts) + " after: " + std::string(status.last_end.view()));
  return out;
}

// Lines of the summary; none when all is well.
static std::string health_text(const proto::NodeStatus& status) {
  std::string out;
  if (const auto words = concerns(status); !words.empty()) out += "  " + joined(words) + "\n";
  if (status.minor_faults + status.major_faults > 0)
    out += formatted("  page faults in the frame loop: %" PRIu64 ", %" PRIu64 " of them with the disk\n",
                     status.minor_faults + status.major_faults, status.major_faults);
  if (status.recording != proto::RecordState::kNone)
    out +=
        formatted("  recorded on the node: %" PRIu64 " frames, %" PRIu64 " dropped\n", status.recorded, status.record_dropped);
  return out;
}

std::string range_text(const std::vector<proto::SequenceRange>& ranges, std::size_t most) {
  std::string text;
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    if (i > 0) text += ", ";
    if (i == most) return text + "..";
    text += std::to_string(ranges[i].begin);
    if (ranges[i].size() > 1) text += "-" + std::to_string(ranges[i].end - 1);
  }
  return text;
}

std::string shared_id_text(const Receiver& receiver, const std::pair<proto::BootId, proto::BootId>& boots) {
  const auto where = [&](const proto::BootId& id) {
    return receiver.sources().at(id).address.text() + " (" + boot_text(id.boot) + ")";
  };
  return "two nodes measure under the id '" + std::string(boots.first.node.view()) + "': " + where(boots.first) + " and " +
         where(boots.second) + "; the record tells their frames apart by boot alone: give one another node.id";
}

std::string concern_text(const std::pair<proto::NodeId, LinkConcern>& concern, const std::string& keys) {
  const std::string node(concern.first.view());
  switch (concern.second) {
    case LinkConcern::kNodeUnknown:
      return "node '" + node + "' has a key, and there is none for it in " + keys + ": srd keygen " + node + " --out " + keys +
             ", and that file at the node";
    case LinkConcern::kOtherKey:
      return "node '" + node + "' has another key than " + keys + "/" + node +
             ".key, or someone else sends in its name: put that file there, as the node's node.key";
    case LinkConcern::kNodeKeyless:
      return "node '" + node + "' sends without a key, and is not accepted: srd keygen " + node + " --out " + keys +
             ", and node.key in its configuration";
    case LinkConcern::kHostKeyless:
      return "node '" + node + "' has a key and waits for a host that has it too: srd listen --keys DIR";
  }
  return {};
}

std::string status_line(const Session& session, double rate_hz) {
  std::set<proto::NodeId> nodes;
  std::uint64_t missing = 0, lost = 0, resent = 0, duplicates = 0;
  for (const auto& [id, source] : session.receiver().sources()) {
    nodes.insert(id.node);
    missing += source.stream.missing();
    lost += source.stream.counts().lost;
    resent += source.status.resent;
    duplicates += source.stream.counts().duplicates;
  }
  std::string line = formatted(
      "%zu %s  %" PRIu64 " frames  %.0f/s  missing %" PRIu64 "  lost %" PRIu64 "  resent %" PRIu64 "  duplicates %" PRIu64,
      nodes.size(), nodes.size() == 1 ? "node" : "nodes", session.rows(), rate_hz, missing, lost, resent, duplicates);
  if (std::isfinite(session.last_height_mm())) line += formatted("  height %.2f mm", session.last_height_mm());
  constexpr std::size_t kMaxNodes = 2;
  float hottest = -std::numeric_limits<float>::infinity();
  std::vector<std::string> worried;
  for (const auto& [node, source] : present(session.receiver())) {
    if (std::isfinite(source->status.temperature_c)) hottest = std::max(hottest, source->status.temperature_c);
    if (const auto words = concerns(source->status); !words.empty())
      worried.push_back(std::string(node.view()) + ": " + joined(words));
  }
  if (std::isfinite(hottest)) line += formatted("  %.0f C", static_cast<double>(hottest));
  for (std::size_t i = 0; i < std::min(worried.size(), kMaxNodes); ++i) line += "  " + worried[i];
  if (worried.size() > kMaxNodes) line += formatted("  and %zu nodes more", worried.size() - kMaxNodes);
  return line;
}

std::string summary_table(const Session& session) {
  const Receiver& receiver = session.receiver();
  if (receiver.sources().empty() && receiver.counts().rejected == 0) return "no node was heard\n";
  std::string out = formatted("%-16s %-20s %10s %9s %8s %8s %10s  %s\n", "node", "boot", "rows", "missing", "lost", "resent",
                              "duplicates", "state");
  for (const auto& [id, source] : receiver.sources()) {
    const StreamCounts& counts = source.stream.counts();
    out += formatted("%-16s %-20s %10" PRIu64 " %9" PRIu64 " %8" PRIu64 " %8" PRIu64 " %10" PRIu64 "  %s\n", id.node.c_str(),
                     boot_text(id.boot).c_str(), counts.delivered, source.stream.missing(), counts.lost, source.status.resent,
                     counts.duplicates, ending_of(source));
    if (source.shares_id) out += "  another node measured under this id at the same time\n";
    if (counts.lost > 0) out += "  frames that are in no record: " + range_text(source.stream.lost_ranges(), 20) + "\n";
    if (source.has_status) out += health_text(source.status);
    if (source.stream.waiting() > 0)
      out += formatted("  %zu frames came after a gap and are not in the record; the node still has them: --append\n",
                       source.stream.waiting());
  }
  if (receiver.counts().rejected > 0)
    out += formatted("%" PRIu64
                     " datagrams were rejected: damaged, not from a node of this version, or not under a key that holds\n",
                     receiver.counts().rejected);
  if (receiver.counts().no_room > 0)
    out += formatted("%" PRIu64 " datagrams came from more nodes than are kept (%zu)\n", receiver.counts().no_room,
                     Receiver::kMaxSources);
  return out;
}

}  // namespace srd::host
