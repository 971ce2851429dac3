// SPDX-License-Identifier: Apache-2.0
#include "dsp/optics/surface_model.hpp"

#include <algorithm>

namespace srd::dsp {

std::array<char, 4> Mode::name() const {
  switch (kind) {
    case Kind::kSlopeX: return {'B', 0, 0, 0};
    case Kind::kSlopeY: return {'C', 0, 0, 0};
    case Kind::kCosine: break;
  }
  return {'A', static_cast<char>('0' + m), static_cast<char>('0' + n), 0};
}

std::optional<Mode> Mode::parse(std::string_view name) {
  if (name == "B") return Mode{Kind::kSlopeX, 0, 0};
  if (name == "C") return Mode{Kind::kSlopeY, 0, 0};
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  if (name.size() != 3 || name[0] != 'A' || !digit(name[1]) || !digit(name[2])) return std::nullopt;
  return Mode{Kind::kCosine, static_cast<std::uint8_t>(name[1] - '0'), static_cast<std::uint8_t>(name[2] - '0')};
}

Result<ModeList> ModeList::standard(int parameters) {
  if (parameters != 1 && parameters != 3 && parameters != 5 && parameters != 8 && parameters != 12)
    return Errc::kInvalidArgument;
  // The order of optics (5).
  static constexpr std::string_view kOrder[] = {"A00", "B", "C", "A10", "A01", "A20", "A02", "A11", "A30", "A03", "A21", "A12"};
  std::array<Mode, 12> modes;
  for (std::size_t i = 0; i < modes.size(); ++i) modes[i] = *Mode::parse(kOrder[i]);
  return make(std::span(modes).first(static_cast<std::size_t>(parameters)));
}

Result<ModeList> ModeList::make(std::span<const Mode> modes) {
  if (modes.empty()) return Errc::kInvalidArgument;
  if (modes.size() > kMaxModes) return Errc::kTooSmall;
  ModeList list;
  for (const Mode& mode : modes) {
    if (mode.m > kMaxHarmonic || mode.n > kMaxHarmonic || list.index_of(mode) >= 0) return Errc::kInvalidArgument;
    if (mode.kind != Mode::Kind::kCosine && (mode.m != 0 || mode.n != 0)) return Errc::kInvalidArgument;
    list.modes_[static_cast<std::size_t>(list.size_++)] = mode;
    list.highest_x_ = std::max<int>(list.highest_x_, mode.m);
    list.highest_y_ = std::max<int>(list.highest_y_, mode.n);
  }
  return list;
}

int ModeList::index_of(Mode mode) const {
  for (int i = 0; i < size_; ++i)
    if ((*this)[i] == mode) return i;
  return -1;
}

template struct SurfaceModel<float>;
template struct SurfaceModel<double>;

}  // namespace srd::dsp
