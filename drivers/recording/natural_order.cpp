// SPDX-License-Identifier: Apache-2.0
#include "drivers/recording/natural_order.hpp"

#include <algorithm>
#include <compare>
#include <set>
#include <string_view>
#include <utility>

namespace srd {

namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || static_cast<unsigned char>(c) >= 0x80; }
bool is_sign(char c) { return c == '-' || c == '+'; }
bool digit_at(std::string_view name, std::size_t at) { return at < name.size() && is_digit(name[at]); }
std::size_t run_end(std::string_view name, std::size_t at) {
  while (digit_at(name, at)) ++at;
  return at;
}

// A sign could stand at 'at': digits behind it, none before.
bool may_be_sign(std::string_view name, std::size_t at) {
  return is_sign(name[at]) && digit_at(name, at + 1) && (at == 0 || !is_digit(name[at - 1]));
}

// The digits behind "12." at the end of a run, where one '.' only joins two runs; empty otherwise.
std::string_view fraction_behind(std::string_view name, std::size_t first, std::size_t end) {
  if (end >= name.size() || name[end] != '.' || !digit_at(name, end + 1)) return {};
  if (first >= 2 && name[first - 1] == '.' && is_digit(name[first - 2])) return {};
  const std::size_t last = run_end(name, end + 1);
  if (last < name.size() && name[last] == '.' && digit_at(name, last + 1)) return {};
  return name.substr(end + 1, last - end - 1);
}

// The name up to 'at', with one mark for every run of digits: names of one series have it in common.
std::string series_before(std::string_view name, std::size_t at) {
  std::string text;
  for (std::size_t i = 0; i < at; ++i)
    if (!is_digit(name[i]))
      text += name[i];
    else if (i == 0 || !is_digit(name[i - 1]))
      text += '0';
  return text;
}

// How all names together are read.
struct Reading {
  bool signs = true, fractions = true;
  std::set<std::string> signed_after;  // series_before() a mark that is a sign although letters or '-' precede it

  [[nodiscard]] bool sign_at(std::string_view name, std::size_t at) const {
    if (!signs || !may_be_sign(name, at)) return false;
    if (at == 0 || (!is_letter(name[at - 1]) && !is_sign(name[at - 1]))) return true;
    return !signed_after.empty() && signed_after.contains(series_before(name, at));
  }
};

// After which letters the mark comes and goes, or is now '-' and now '+'.
std::set<std::string> signed_series(const std::vector<std::string>& names) {
  std::set<std::pair<std::string, char>> seen;
  for (const std::string& name : names)
    for (std::size_t i = 0; i < name.size(); ++i) {
      const bool number_starts = is_digit(name[i]) && (i == 0 || !is_digit(name[i - 1]));
      if (number_starts || may_be_sign(name, i)) seen.emplace(series_before(name, i), number_starts ? '0' : name[i]);
    }
  std::set<std::string> series;
  for (const auto& [before, mark] : seen)
    if (is_sign(mark) && (seen.contains({before, '0'}) || seen.contains({before, mark == '-' ? '+' : '-'})))
      series.insert(before);
  return series;
}

// Digits behind a '.' are a fraction where they carry leading zeros ("0.05" beside "0.5"), or where none ends in 0 as
// counted ones do ("1.10" beside "1.9"). Of one length all, the readings agree.
bool look_like_fractions(const std::vector<std::string>& names) {
  std::set<std::size_t> lengths;
  bool leading = false, trailing = false;
  for (const std::string& name : names)
    for (std::size_t i = 0; i < name.size(); ++i) {
      if (!is_digit(name[i])) continue;
      const std::size_t end = run_end(name, i);
      const std::string_view behind = fraction_behind(name, i, end);
      if (!behind.empty()) {
        lengths.insert(behind.size());
        leading = leading || (behind.size() > 1 && behind.front() == '0');
        trailing = trailing || (behind.size() > 1 && behind.back() == '0');
      }
      i = end - 1;
    }
  return lengths.size() < 2 || leading || !trailing;
}

// A byte, or a whole number with what belongs to it.
struct Part {
  char byte = 0;  // '0' of a number: no other byte lies between the digits
  bool negative = false;
  std::string_view whole, fraction;  // without the zeros that say nothing

  friend std::strong_ordering operator<=>(const Part& a, const Part& b) {
    if (a.byte != b.byte) return static_cast<unsigned char>(a.byte) <=> static_cast<unsigned char>(b.byte);
    if (a.negative != b.negative) return b.negative <=> a.negative;
    const Part& x = a.negative ? b : a;
    const Part& y = a.negative ? a : b;
    if (x.whole.size() != y.whole.size()) return x.whole.size() <=> y.whole.size();
    if (x.whole != y.whole) return x.whole <=> y.whole;
    return x.fraction <=> y.fraction;
  }
};

using Parts = std::vector<Part>;

Parts parts_of(std::string_view name, const Reading& reading) {
  Parts parts;
  for (std::size_t i = 0; i < name.size();) {
    const bool sign = reading.sign_at(name, i);
    if (!sign && !is_digit(name[i])) {
      parts.push_back({name[i], false, {}, {}});
      ++i;
      continue;
    }
    const std::size_t first = sign ? i + 1 : i, end = run_end(name, first);
    Part part{'0', sign && name[i] == '-', name.substr(first, end - first), {}};
    i = end;
    if (reading.fractions) {
      part.fraction = fraction_behind(name, first, end);
      if (!part.fraction.empty()) i += 1 + part.fraction.size();
    }
    while (part.whole.starts_with('0')) part.whole.remove_prefix(1);
    while (part.fraction.ends_with('0')) part.fraction.remove_suffix(1);
    if (part.whole.empty() && part.fraction.empty()) part.negative = false;
    parts.push_back(part);
  }
  return parts;
}

std::vector<std::string> sorted(const std::vector<std::string>& names, const Reading& reading) {
  std::vector<std::pair<Parts, std::string_view>> keys;
  keys.reserve(names.size());
  for (const std::string& name : names) keys.emplace_back(parts_of(name, reading), name);
  std::sort(keys.begin(), keys.end());  // equal numbers ("1", "01"): byte by byte
  std::vector<std::string> out;
  out.reserve(names.size());
  for (const auto& [parts, name] : keys) out.emplace_back(name);
  return out;
}

}  // namespace

std::string sort_naturally(std::vector<std::string>& names) {
  const Reading taken{true, look_like_fractions(names), signed_series(names)};
  const Reading other_sign{false, taken.fractions, {}};
  Reading other_point = taken;
  other_point.fractions = !taken.fractions;
  std::vector<std::string> order = sorted(names, taken);
  const std::vector<std::string> unsigned_order = sorted(names, other_sign), point_order = sorted(names, other_point);
  std::string note;
  if (unsigned_order != order) note = "a '-' before digits as a sign";
  if (point_order != order)
    note += std::string(note.empty() ? "" : ", ") + "a '.' between digits as " +
            (taken.fractions ? "a decimal point" : "a separator");
  if (!note.empty())
    note = "the file names can be read in two ways; taken: " + note + "; first " + order.front() + ", last " + order.back() +
           "; rename the files if that is not their order in time";
  names = std::move(order);
  return note;
}

}  // namespace srd
