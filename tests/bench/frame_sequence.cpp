// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/frame_sequence.hpp"

#include <array>
#include <cstdio>

namespace srd::bench {

namespace {

constexpr double kMagic = 20160721;

struct Close {
  void operator()(std::FILE* file) const { (void)std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, Close>;

// One list of numbers, written and read in one order.
template <class Number>
void exchange(FrameSequence& s, int& modes, int& frames, const Number& number) {
  const auto whole = [&](int& value) {
    double wide = value;
    number(wide);
    value = static_cast<int>(wide);
  };
  whole(s.width);
  whole(s.height);
  number(s.rate_hz);
  number(s.media.air);
  number(s.media.water);
  number(s.model.lx);
  number(s.model.ly);
  number(s.model.x0);
  number(s.model.y0);
  whole(s.rows);
  whole(s.columns);
  number(s.square_mm);
  number(s.level_guess_mm);
  whole(modes);
  whole(frames);
  for (int i = 0; i < 9; ++i) number(s.view.pose.rotation(i / 3, i % 3));
  for (int i = 0; i < 3; ++i) number(s.view.pose.translation[i]);
}

}  // namespace

std::vector<dsp::Vec3<double>> FrameSequence::points() const {
  std::vector<dsp::Vec3<double>> points;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) points.emplace_back(row * square_mm, column * square_mm, 0.0);
  return points;
}

bool write_sequence(const std::string& file, const FrameSequence& sequence) {
  const File out(std::fopen(file.c_str(), "wb"));
  if (!out) return false;
  FrameSequence copy = sequence;
  copy.frames.clear();
  int modes = sequence.model.modes.size(), frames = sequence.size();
  bool fine = true;
  const auto put = [&](double value) { fine = fine && std::fwrite(&value, sizeof value, 1, out.get()) == 1; };
  put(kMagic);
  exchange(copy, modes, frames, put);
  const auto& camera = sequence.view.camera;
  for (const double value : {camera.fx(), camera.fy(), camera.cx(), camera.cy()}) put(value);
  for (const double value : camera.distortion()) put(value);
  for (const auto& frame : sequence.frames)
    fine = fine && std::fwrite(frame.data(), 1, frame.size(), out.get()) == frame.size();
  return fine;
}

std::optional<FrameSequence> read_sequence(const std::string& file) {
  const File in(std::fopen(file.c_str(), "rb"));
  if (!in) return std::nullopt;
  FrameSequence s;
  int modes = 0, frames = 0;
  bool fine = true;
  const auto get = [&](double& value) { fine = fine && std::fread(&value, sizeof value, 1, in.get()) == 1; };
  double magic = 0;
  get(magic);
  if (!fine || magic != kMagic) return std::nullopt;
  exchange(s, modes, frames, get);
  double fx = 0, fy = 0, cx = 0, cy = 0;
  for (double* value : {&fx, &fy, &cx, &cy}) get(*value);
  std::array<double, 14> distortion{};
  for (double& value : distortion) get(value);
  const auto list = dsp::ModeList::standard(modes);
  const auto camera = dsp::CameraModel<double>::make(fx, fy, cx, cy, distortion);
  if (!fine || !list || !camera || s.width <= 0 || s.height <= 0 || frames < 1) return std::nullopt;
  s.model.modes = *list;
  s.view.camera = *camera;
  for (int i = 0; i < frames; ++i) {
    auto& frame = s.frames.emplace_back(static_cast<std::size_t>(s.width) * static_cast<std::size_t>(s.height));
    if (std::fread(frame.data(), 1, frame.size(), in.get()) != frame.size()) return std::nullopt;
  }
  return s;
}

}  // namespace srd::bench
