// SPDX-License-Identifier: Apache-2.0
// A date as a number: days since 1970-01-01 UTC. 0: not known.
#pragma once

#include <charconv>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace srd {

using Day = std::uint32_t;

[[nodiscard]] inline Day today() {
  const auto days = std::chrono::floor<std::chrono::days>(std::chrono::system_clock::now());
  return static_cast<Day>(days.time_since_epoch().count());
}

// "2026-11-28"
[[nodiscard]] inline std::string day_text(Day day) {
  const std::chrono::year_month_day date{std::chrono::sys_days(std::chrono::days(day))};
  const auto two = [](unsigned number) { return (number < 10 ? "0" : "") + std::to_string(number); };
  return std::to_string(static_cast<int>(date.year())) + "-" + two(static_cast<unsigned>(date.month())) + "-" +
         two(static_cast<unsigned>(date.day()));
}

// As day_text writes it, from 1970-01-02 to 9999; nothing else.
[[nodiscard]] inline std::optional<Day> parse_day(std::string_view text) {
  if (text.size() != 10) return std::nullopt;
  const auto number = [&](std::size_t at, std::size_t length) {
    unsigned value = 0;
    const char* end = text.data() + at + length;
    return std::from_chars(text.data() + at, end, value).ptr == end ? value : 0U;
  };
  const std::chrono::year_month_day date{std::chrono::year(static_cast<int>(number(0, 4))), std::chrono::month(number(5, 2)),
                                         std::chrono::day(number(8, 2))};
  if (!date.ok() || static_cast<int>(date.year()) < 1970) return std::nullopt;
  const Day day = static_cast<Day>(std::chrono::sys_days(date).time_since_epoch().count());
  if (day == 0 || day_text(day) != text) return std::nullopt;
  return day;
}

}  // namespace srd
