// SPDX-License-Identifier: Apache-2.0
// Frames as boards would send them of one moving surface: the true coefficients at the true moment, their random error drawn
// from the information that the frame states, times by each board's own clock.
#pragma once

#include <cmath>
#include <random>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "host/coefficients/frame_sink.hpp"
#include "proto/information.hpp"

namespace srd::host {

struct BoardOfTest {
  std::string name;
  double hz = 50, phase_s = 0;       // of its exposures
  double offset_s = 0, sd_s = 1e-4;  // of its clock: what it is wrong by, and what it says
  double noise = 1;                  // scale of its deviations
  Eigen::VectorXd shift{};           // mm, added to its coefficients; empty: none
  double leak = 0;                   // share of the wave's coefficients that its model gets wrong
};

// A tank's swash in three modes: frequencies of 0.9, 1.3, 1.9 Hz, a few mm each.
inline Eigen::VectorXd swash(double t) {
  Eigen::VectorXd a(5);
  a << 80, 2.0 * std::sin(2 * M_PI * 0.9 * t), 1.5 * std::sin(2 * M_PI * 1.3 * t + 1), std::sin(2 * M_PI * 1.9 * t + 2),
      0.5 * std::sin(2 * M_PI * 1.6 * t + 3);
  return a;
}

class BoardsOfOneSurface {
 public:
  explicit BoardsOfOneSurface(unsigned seed) : random_(seed) {}

  static dsp::SurfaceModel<float> model() { return {*dsp::ModeList::standard(5), 400.0F, 300.0F, 0.0F, 0.0F}; }

  // Of the random error, mm^2: correlated, as a few views of a pattern leave it.
  static Eigen::MatrixXd covariance(double noise) {
    Eigen::MatrixXd c(5, 5);
    for (int i = 0; i < 5; ++i)
      for (int j = 0; j < 5; ++j) c(i, j) = (i == j ? 1.0 : 0.4 / (1 + std::abs(i - j))) * 1e-4 * noise * noise;
    return c;
  }

  // The board's frame number k of a surface that is a(t) at the true time t.
  template <class Truth>
  proto::CoefficientFrame frame(const BoardOfTest& board, std::int64_t k, const Truth& truth) {
    const double t = board.phase_s + static_cast<double>(k) / board.hz;
    Eigen::VectorXd a = truth(t);
    a += board.leak * (a - truth(0.0)).reverse();
    const Eigen::MatrixXd c = covariance(board.noise);
    const Eigen::MatrixXd root = c.llt().matrixL();
    Eigen::VectorXd draw(5);
    for (double& each : draw) each = normal_(random_);
    a += root * draw;
    if (board.shift.size() > 0) a += board.shift;
    proto::CoefficientFrame out;
    out.status = proto::FrameStatus::kOk;
    out.model = model();
    out.centre_x_mm = 200;
    out.centre_y_mm = 150;
    out.pattern_x_mm = 360;
    out.pattern_y_mm = 260;
    out.refractive_index = 1.333F;
    out.coefficients = a.cast<float>();
    const dsp::InformationMatrix<double> information = c.inverse();
    (void)proto::quantise(information, out.information);
    out.stamp.wall_time_ns = kBegin + std::llround((t + board.offset_s) * 1e9);
    out.stamp.wall_uncertainty_ns = static_cast<std::uint64_t>(board.sd_s * 1e9);
    out.corners_expected = out.corners_found = out.corners_used = 200;
    out.reprojection_rms_px = 0.02F;
    return out;
  }

  static constexpr std::int64_t kBegin = 1'700'000'000'000'000'000;
  static double seconds(const proto::CoefficientFrame& frame) {
    return static_cast<double>(frame.stamp.wall_time_ns - kBegin) * 1e-9;
  }
  double normal() { return normal_(random_); }

 private:
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
};

inline proto::BootId boot_of(const std::string& name, std::uint64_t boot = 1) { return {*proto::NodeId::make(name), boot}; }

struct KeptFrames final : FrameSink {
  std::vector<proto::CoefficientFrame> frames;
  Outcome<void> write(const proto::BootId&, std::uint64_t, const proto::CoefficientFrame& frame) override {
    frames.push_back(frame);
    return {};
  }
  Outcome<void> flush() override { return {}; }
};

}  // namespace srd::host
