// SPDX-License-Identifier: Apache-2.0
#include "drivers/geometry/lens_model.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <iterator>

namespace srd {

namespace {

// The order of the coefficients is OpenCV's in all of these: k1 k2 p1 p2, k3, k4 k5 k6, s1..s4, tau.
struct Family {
  std::string_view name;
  std::array<std::size_t, 3> counts;
};
constexpr Family kFamilies[] = {
    {"plumb_bob", {4, 5, 5}},
    {"radtan", {4, 5, 5}},
    {"radial_tangential", {4, 5, 5}},
    {"brown_conrady", {4, 5, 5}},
    {"rational_polynomial", {8, 12, 14}},
    {"rational", {8, 12, 14}},
    {"thin_prism", {12, 14, 14}},
    {"rational_thin_prism", {12, 14, 14}},
    {"tilted", {14, 14, 14}},
};

std::string plain(std::string_view name) {
  std::string text;
  for (const char c : name) text += c == '-' || c == ' ' ? '_' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

std::string counts_text(const Family& family) {
  std::string text;
  std::size_t before = 0;
  for (const std::size_t n : family.counts) {
    if (n != before) text += (text.empty() ? "" : " or ") + std::to_string(n);
    before = n;
  }
  return text;
}

std::string quoted(std::string_view text) { return "'" + std::string(text.substr(0, 60)) + "'"; }

}  // namespace

LensRefusal check_lens_model(std::string_view key, std::string_view name, std::size_t n) {
  const std::string asked = plain(name);
  if (key == "fisheye_model") {
    if (asked == "0" || asked == "false") return {};
    return {"0: the polynomial lens", quoted(name) + ": a fisheye's angles are another formula"};
  }
  if (key != "distortion_model") {
    if (asked == "pinhole") return {};
    return {"pinhole", quoted(name)};
  }
  const auto* family =
      std::find_if(std::begin(kFamilies), std::end(kFamilies), [&](const Family& f) { return f.name == asked; });
  if (family == std::end(kFamilies)) {
    std::string names;
    for (const Family& f : kFamilies) names += (names.empty() ? "" : ", ") + std::string(f.name) + " (" + counts_text(f) + ")";
    return {"one of these, with so many coefficients: " + names, quoted(name)};
  }
  if (std::find(family->counts.begin(), family->counts.end(), n) != family->counts.end()) return {};
  return {counts_text(*family) + " coefficients, which " + std::string(family->name) + " has", std::to_string(n)};
}

}  // namespace srd
