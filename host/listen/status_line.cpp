#include "host/listen/status_line.hpp"

#include <array>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <set>

namespace srd::host {
namespace {

template <class... Values>
std::string format(const char* pattern, Values... values) {
  std::array<char, 256> text;
  const int size = std::snprintf(text.data(), text.size(), pattern, values...);
  return {text.data(), std::min(static_cast<std::size_t>(size), text.size() - 1)};
}

const char* ending_of(const Source& source) {
  if (source.ended && source.stream.missing() == 0) return "ended";
  if (source.has_status) return proto::to_string(source.status.state);
  return "";
}

}  // namespace

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
  std::string line = format("%zu %s  %" PRIu64 " frames  %.0f/s  missing %" PRIu64 "  lost %" PRIu64 "  resent %" PRIu64
                            "  duplicates %" PRIu64,
                            nodes.size(), nodes.size() == 1 ? "node" : "nodes", session.rows(), rate_hz, missing, lost,
                            resent, duplicates);
  if (std::isfinite(session.last_height_mm())) line += format("  height %.2f mm", session.last_height_mm());
  return line;
}

std::string summary_table(const Session& session) {
  const Receiver& receiver = session.receiver();
  if (receiver.sources().empty() && receiver.counts().rejected == 0) return "no node was heard\n";
  std::string out = format("%-16s %-20s %10s %9s %8s %8s %10s  %s\n", "node", "boot", "rows", "missing", "lost", "resent",
                           "duplicates", "state");
  for (const auto& [id, source] : receiver.sources()) {
    const StreamCounts& counts = source.stream.counts();
    out += format("%-16s %-20" PRIu64 " %10" PRIu64 " %9" PRIu64 " %8" PRIu64 " %8" PRIu64 " %10" PRIu64 "  %s\n",
                  id.node.c_str(), id.boot, counts.delivered, source.stream.missing(), counts.lost, source.status.resent,
                  counts.duplicates, ending_of(source));
    if (counts.lost > 0)
      out += "  frames that are in no record: " + range_text(source.stream.lost_ranges(), 20) + "\n";
    if (source.stream.waiting() > 0)
      out += format("  %zu frames came after a gap and are not in the record; the node still has them: --append\n",
                    source.stream.waiting());
  }
  if (receiver.counts().rejected > 0)
    out += format("%" PRIu64 " datagrams were rejected: damaged, or not from a node of this version\n",
                  receiver.counts().rejected);
  if (receiver.counts().no_room > 0)
    out += format("%" PRIu64 " datagrams came from more nodes than are kept (%zu)\n", receiver.counts().no_room,
                  Receiver::kMostSources);
  return out;
}

}  // namespace srd::host
