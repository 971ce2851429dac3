// SPDX-License-Identifier: Apache-2.0
// frame_digest FILE FRAMES: what the front end and the chain make of a prerendered sequence, to be compared between
// architectures. A line a frame: a digest of every number of every corner of the full detection, the corners tracked, and
// the surface's heights over the pattern, mm.
#include <cstdio>
#include <cstdlib>

#include "dsp/frontend/corner_detector.hpp"
#include "tests/bench/frame_chain.hpp"

namespace {

// FNV-1a.
class Digest {
 public:
  void add(std::int64_t value) {
    for (int i = 0; i < 8; ++i) {
      sum_ ^= static_cast<std::uint8_t>(value >> (8 * i));
      sum_ *= 1099511628211ULL;
    }
  }
  [[nodiscard]] unsigned long long value() const { return sum_; }

 private:
  std::uint64_t sum_ = 14695981039346656037ULL;
};

}  // namespace

int main(int argc, char** argv) {
  const auto sequence = argc == 3 ? srd::bench::read_sequence(argv[1]) : std::nullopt;
  const int frames = argc == 3 ? std::atoi(argv[2]) : 0;
  if (!sequence || frames < 1 || frames > sequence->size()) {
    (void)std::fprintf(stderr, "usage: frame_digest FILE FRAMES; FILE by srd_prerender\n");
    return 2;
  }
  auto chain = srd::bench::FrameChain::make(*sequence);
  if (!chain) return 3;
  srd::dsp::CornerDetector detector(sequence->width, sequence->height, 4000);
  const auto points = sequence->points();
  const auto model = sequence->model.cast<float>();
  for (int frame = 0; frame < frames; ++frame) {
    Digest digest;
    const auto corners = detector.detect(sequence->image(frame), {});
    for (const auto& fit : corners)
      for (const std::int64_t value :
           {std::int64_t{fit.corner.u.raw()}, std::int64_t{fit.corner.v.raw()}, std::int64_t{fit.corner.sigma_q12},
            std::int64_t{fit.corner.response}, std::int64_t{fit.corner.mean}, std::int64_t{fit.corner.contrast},
            std::int64_t{fit.shape.n1.x}, std::int64_t{fit.shape.n1.y}, std::int64_t{fit.shape.n2.x},
            std::int64_t{fit.shape.n2.y}, std::int64_t{fit.shape.blur_q12}, std::int64_t{fit.residual_q6}})
        digest.add(value);
    (void)chain->process(sequence->image(frame), sequence->time_ns(frame));
    std::printf("%d %zu %016llx %d", frame, corners.size(), digest.value(), chain->result().estimate.corners_used);
    if (chain->result().has_surface())
      for (const auto& point : points)
        std::printf(" %.6f", static_cast<double>(model.height(chain->result().estimate.coefficients,
                                                              static_cast<float>(point.x()), static_cast<float>(point.y()))));
    std::printf("\n");
  }
  return 0;
}
