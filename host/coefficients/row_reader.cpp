// SPDX-License-Identifier: Apache-2.0
#include "host/coefficients/row_reader.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "host/coefficients/columns.hpp"

namespace srd::host {
namespace {

struct Columns {
  std::vector<std::string> node, boot, clock, status, metric;
  std::vector<std::uint64_t> sequence;
  std::vector<std::int64_t> time_ns;
  std::vector<double> corners_used, mean_error, height_mm;
  dsp::ModeList modes;
  std::vector<std::vector<double>> coefficients, deviations, systematic;  // a column each
  std::vector<double> systematic_height;
};

// Takes the column or remembers the first problem.
template <class T>
void take(Outcome<std::vector<T>> column, std::vector<T>& into, std::optional<Problem>& problem) {
  if (column) {
    into = std::move(*column);
  } else if (!problem) {
    problem = std::move(column.error());
    if (problem->expected.empty()) problem->expected = kColumnsText;
  }
}

// NaN in every row where there is no such column.
Outcome<std::vector<double>> numbers_if_there(const CsvTable& table, const std::string& name) {
  const auto& names = table.columns();
  if (std::find(names.begin(), names.end(), name) == names.end())
    return std::vector<double>(table.rows(), std::numeric_limits<double>::quiet_NaN());
  return table.numbers(name);
}

Outcome<dsp::ModeList> modes_of(const CsvTable& table, const std::string& file) {
  std::vector<dsp::Mode> modes;
  for (const std::string& column : table.columns()) {
    if (column.starts_with("sd_") && !dsp::Mode::parse(column.substr(3)))
      return Problem{.what = "column '" + column + "' names no mode", .where = file + ":1", .expected = kColumnsText};
    if (const auto mode = dsp::Mode::parse(column)) modes.push_back(*mode);
  }
  const auto list = dsp::ModeList::make(modes);
  if (!list)
    return Problem{.what = "no list of modes",
                   .where = file + ":1",
                   .expected = "1 to " + std::to_string(dsp::kMaxModes) + " mode columns: " + kColumnsText,
                   .found = std::to_string(modes.size()) + " of them"};
  return *list;
}

Outcome<Columns> columns_of(const CsvTable& table, const std::string& file) {
  Columns c;
  std::optional<Problem> problem;
  take(table.words("node"), c.node, problem);
  take(table.words("boot"), c.boot, problem);
  take(table.unsigned_integers("sequence"), c.sequence, problem);
  take(table.integers("time_ns"), c.time_ns, problem);
  take(table.words("clock"), c.clock, problem);
  take(table.words("status"), c.status, problem);
  take(table.numbers("n_used"), c.corners_used, problem);
  take(table.numbers("mean_error"), c.mean_error, problem);
  take(table.words("metric"), c.metric, problem);
  take(table.numbers("height_mm"), c.height_mm, problem);
  if (problem) return *problem;
  const auto modes = modes_of(table, file);
  if (!modes) return modes.error();
  c.modes = *modes;
  for (const dsp::Mode& mode : c.modes) {
    const std::string name = mode_name(mode);
    take(table.numbers(name), c.coefficients.emplace_back(), problem);
    take(table.numbers("sd_" + name), c.deviations.emplace_back(), problem);
    take(numbers_if_there(table, kSystematicPrefix + name), c.systematic.emplace_back(), problem);
  }
  take(numbers_if_there(table, kSystematicHeight), c.systematic_height, problem);
  if (problem) return *problem;
  return c;
}

// The node that the person means.
Outcome<std::string> choose_node(const std::vector<std::string>& names, const std::string& wanted, const std::string& file) {
  const std::set<std::string> present(names.begin(), names.end());
  if (wanted.empty() && present.size() == 1) return *present.begin();
  if (!wanted.empty() && present.contains(wanted)) return wanted;
  std::string list;
  for (const std::string& name : present) list += (list.empty() ? "" : ", ") + name;
  if (wanted.empty())
    return Problem{Exit::kUsage, "the file holds several nodes", file, "one of them named", list, "--node NAME"};
  return Problem{Exit::kUsage, "no node '" + wanted + "' in the file", file, "one of: " + list};
}

// Boots in the file's order, each in order of sequence: resent frames may stand late in a file.
Outcome<void> put_in_order(const CsvTable& table, std::vector<std::pair<CoefficientRow, std::size_t>>& rows) {
  std::map<std::string, std::size_t> rank;
  for (const auto& [row, line] : rows) rank.emplace(row.boot, rank.size());
  const auto key = [&](const auto& entry) { return std::pair(rank[entry.first.boot], entry.first.sequence); };
  std::stable_sort(rows.begin(), rows.end(), [&](const auto& a, const auto& b) { return key(a) < key(b); });
  for (std::size_t i = 1; i < rows.size(); ++i)
    if (key(rows[i - 1]) == key(rows[i]))
      return Problem{
          .what = "the frame is there twice",
          .where = table.where(rows[i].second),
          .expected = "each boot and sequence once",
          .found = "sequence " + std::to_string(rows[i].first.sequence) + " also at " + table.where(rows[i - 1].second)};
  return {};
}

// After a reboot the clock may start anew: its earlier frames cannot stand on the same axis.
void drop_other_clocks(CoefficientRun& run) {
  std::size_t first = 0;
  for (std::size_t i = 1; i < run.rows.size(); ++i)
    if (run.rows[i].boot != run.rows[i - 1].boot && run.rows[i].time_ns <= run.rows[i - 1].time_ns) first = i;
  if (first == 0) return;
  run.notes.push_back(std::to_string(first) + " frames before boot " + run.rows[first].boot +
                      " are left out: the node's clock started anew");
  run.rows.erase(run.rows.begin(), run.rows.begin() + static_cast<std::ptrdiff_t>(first));
}

// A strobed run has dark frames between the lit ones: they are no gaps.
void take_out_dark(CoefficientRun& run) {
  std::vector<CoefficientRow> lit;
  std::uint64_t dark = 0, all_dark = 0;
  std::string boot;
  for (const CoefficientRow& row : run.rows) {
    if (row.boot != boot) dark = 0;
    boot = row.boot;
    if (row.status == "dark" && !row.has_surface()) {
      ++dark;
      ++all_dark;
      continue;
    }
    lit.push_back(row);
    lit.back().dark_before = dark;
    dark = 0;
  }
  if (all_dark == 0) return;
  run.notes.push_back(std::to_string(all_dark) + " dark frames are left out");
  run.rows = std::move(lit);
}

}  // namespace

bool CoefficientRow::is_flagged() const {
  return !has_surface() || status == "poor_fit" || status == "inconsistent" || status == "interlaced" ||
         status == "not_converged";
}

std::uint64_t missing_between(const CoefficientRow& before, const CoefficientRow& row) {
  return row.sequence - before.sequence - 1 - row.dark_before;
}

bool CoefficientRow::has_surface() const { return coefficients.size() > 0 && std::isfinite(coefficients[0]); }

std::size_t CoefficientRun::surfaces() const {
  return static_cast<std::size_t>(std::count_if(rows.begin(), rows.end(), [](const auto& r) { return r.has_surface(); }));
}

Outcome<CoefficientRun> read_coefficient_run(const std::filesystem::path& file, const std::string& node) {
  const auto table = CsvTable::read(file);
  if (!table) return table.error();
  return coefficient_run(*table, file.string(), node);
}

Outcome<CoefficientRun> coefficient_run(const CsvTable& table, const std::string& file, const std::string& node) {
  const auto c = columns_of(table, file);
  if (!c) return c.error();
  if (table.rows() == 0)
    return Problem{.what = "no frames",
                   .where = file + ":1",
                   .expected = "a row a frame below the header",
                   .advice = "check that the node sent frames and that srd listen ended well"};
  const auto chosen = choose_node(c->node, node, file);
  if (!chosen) return chosen.error();

  CoefficientRun run{.file = file, .node = *chosen, .clock = {}, .metric = {}, .modes = c->modes, .rows = {}, .notes = {}};
  if (table.cut_short()) run.notes.push_back("the file ends in the middle of a line: that line is left out");
  if (const std::size_t row = table.first_rounded("time_ns"); row < table.rows())
    run.notes.push_back("times are rounded to about 15 digits, by the program that saved the file again (" + table.where(row) +
                        ")");
  std::vector<std::pair<CoefficientRow, std::size_t>> rows;
  const int n_modes = run.modes.size();
  for (std::size_t i = 0; i < table.rows(); ++i) {
    if (c->node[i] != *chosen) continue;
    CoefficientRow row{.boot = c->boot[i],
                       .sequence = c->sequence[i],
                       .time_ns = c->time_ns[i],
                       .status = c->status[i],
                       .corners_used = c->corners_used[i],
                       .mean_error = c->mean_error[i],
                       .height_mm = c->height_mm[i],
                       .coefficients = dsp::Coefficients<double>(n_modes),
                       .standard_deviation = dsp::Coefficients<double>(n_modes),
                       .systematic_deviation = dsp::Coefficients<double>(n_modes),
                       .systematic_height = c->systematic_height[i]};
    int present = 0;
    for (int j = 0; j < n_modes; ++j) {
      row.coefficients[j] = c->coefficients[static_cast<std::size_t>(j)][i];
      row.standard_deviation[j] = c->deviations[static_cast<std::size_t>(j)][i];
      row.systematic_deviation[j] = c->systematic[static_cast<std::size_t>(j)][i];
      present += std::isfinite(row.coefficients[j]) ? 1 : 0;
    }
    if (present != 0 && present != n_modes)
      return Problem{.what = "the row has some of its coefficients",
                     .where = table.where(i),
                     .expected = "all " + std::to_string(n_modes) + ", or none for a frame without a surface",
                     .found = std::to_string(present)};
    if (present == 0) row.height_mm = std::numeric_limits<double>::quiet_NaN();
    if (run.clock.empty()) run.clock = c->clock[i];
    if (run.metric.empty() && present != 0) run.metric = c->metric[i];
    rows.emplace_back(std::move(row), i);
  }
  if (auto ordered = put_in_order(table, rows); !ordered) return ordered.error();
  run.rows.reserve(rows.size());
  for (auto& [row, line] : rows) run.rows.push_back(std::move(row));
  drop_other_clocks(run);
  take_out_dark(run);
  if (run.rows.empty())
    return Problem{.what = "no frames but dark ones",
                   .where = file + ":2",
                   .expected = "frames with light",
                   .found = std::to_string(rows.size()) + " dark frames",
                   .advice = "check the strobe and the exposure"};
  return run;
}

Outcome<void> require_surface(const CoefficientRun& run) {
  if (run.surfaces() > 0) return {};
  std::map<std::string, int> counts;
  for (const CoefficientRow& row : run.rows) ++counts[row.status];
  std::string found = std::to_string(run.rows.size()) + " frames:";
  for (const auto& [status, count] : counts) found += " " + std::to_string(count) + " " + status;
  return Problem{.what = "no frame has a surface",
                 .where = run.file + ":2",
                 .expected = "at least one row with coefficients",
                 .found = found,
                 .advice = "look at the statuses: they say why the node found no surface"};
}

}  // namespace srd::host
