// SPDX-License-Identifier: Apache-2.0
// Whether programs that read tables take a word for something else: a number, a truth value, a missing one, a date. R, pandas,
// Octave and spreadsheets guess a column's kind from its cells, and a node's name is such a cell.
#pragma once

#include <array>
#include <string_view>

namespace srd::proto {

namespace detail {

constexpr char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }
constexpr bool digit(char c) { return c >= '0' && c <= '9'; }
constexpr bool letter(char c) { return lower(c) >= 'a' && lower(c) <= 'z'; }

constexpr bool same(std::string_view word, std::string_view lower_case) {
  if (word.size() != lower_case.size()) return false;
  for (std::size_t i = 0; i < word.size(); ++i)
    if (lower(word[i]) != lower_case[i]) return false;
  return true;
}

constexpr bool only_digits_and(std::string_view word, std::string_view others) {
  for (const char c : word)
    if (!digit(c) && others.find(lower(c)) == std::string_view::npos) return false;
  return true;
}

// 12e3, 1.5D-2, 0x1F, 1L, 2i, 1_000: a digit or a point first, then what a number has.
constexpr bool reads_as_number(std::string_view word) {
  if (word.starts_with('-')) word.remove_prefix(1);
  if (word.size() > 2 && word[0] == '0' && lower(word[1]) == 'x') return only_digits_and(word.substr(2), "abcdefp.-");
  if (word.empty() || !(digit(word[0]) || word[0] == '.')) return false;
  int letters = 0;
  for (const char c : word) letters += letter(c) ? 1 : 0;
  return letters <= 2 && only_digits_and(word, "ed.-_lijf");
}

// mar-1, SEPT2, 1-may: spreadsheets make dates of them.
constexpr bool reads_as_date(std::string_view word) {
  constexpr std::array<std::string_view, 25> kMonths{"january", "february",  "march",   "april",    "may",      "june", "july",
                                                     "august",  "september", "october", "november", "december", "jan",  "feb",
                                                     "mar",     "apr",       "jun",     "jul",      "aug",      "sept", "sep",
                                                     "oct",     "nov",       "dec",     "mai"};
  for (const std::string_view month : kMonths) {
    if (word.size() <= month.size()) continue;
    const std::size_t rest = word.size() - month.size();
    if (same(word.substr(0, month.size()), month) && only_digits_and(word.substr(month.size()), "-._")) return true;
    if (same(word.substr(rest), month) && only_digits_and(word.substr(0, rest), "-._")) return true;
  }
  return false;
}

}  // namespace detail

[[nodiscard]] constexpr bool reads_as_value(std::string_view word) {
  constexpr std::array<std::string_view, 15> kValues{"na",       "n.a.", "nan",   "nat", "null", "none", "nil", "inf",
                                                     "infinity", "true", "false", "t",   "f",    "yes",  "no"};
  std::string_view unsigned_word = word;
  if (unsigned_word.starts_with('-')) unsigned_word.remove_prefix(1);
  for (const std::string_view value : kValues)
    if (detail::same(unsigned_word, value)) return true;
  bool any_letter = false;
  for (const char c : word) any_letter = any_letter || detail::letter(c);
  return !any_letter || detail::reads_as_number(word) || detail::reads_as_date(word);
}

}  // namespace srd::proto
