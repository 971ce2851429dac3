// SPDX-License-Identifier: Apache-2.0
// One surface from the frames of several boards, while they come. Optics (18), (40).
//
// The slowest board gives the moments; every other board's surface is interpolated to them (board_track.hpp) and all are added
// as information. A moment is fused once each board that is heard has frames beyond it, or kPatience after it. Boards may
// come and go. A board that no longer sees what the others see is told, and left out while two others agree.
// A sink of frames before other sinks, which get the fused ones as of a node of their own. One thread.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "host/coefficients/frame_sink.hpp"
#include "host/fusion/board_watch.hpp"
#include "host/fusion/tolerance.hpp"

namespace srd::host {

// Why a frame of a board is in no fused surface.
enum class Unpaired : std::uint8_t {
  kNoSurface,     // its status is not ok, a coefficient is at its bound, or it says nothing of its deviations
  kNoWallTime,    // the board does not know the time, or not how well
  kClockUnsure,   // not well enough for the waves
  kOtherSurface,  // the board's modes cannot be told apart over the area that it sees
  kNoMoment,      // no moment of the slowest board lies near; it may have served to interpolate
  kLate,          // it came after its moment was fused, or before its predecessor
  kMoved,         // the board disagrees with the others
};
inline constexpr std::size_t kUnpairedCount = 7;
[[nodiscard]] const char* to_string(Unpaired cause);

struct BoardInFusion {
  BoardPlacement placement;
  std::optional<double> clock_sd_ms;  // stated by hand: instead of what the board says of its clock
};

struct FusionOptions {
  std::string id = "fused";                     // a node's name
  std::uint64_t boot = 0;                       // random
  std::map<std::string, BoardInFusion> boards;  // empty: every node, all in one frame
  // The common surface. Without: of the board with most modes, and the modes of all that share its lengths and place.
  std::optional<dsp::SurfaceModel<double>> model;
  std::optional<double> pair_ms;                   // instead of what follows from the waves
  std::vector<FrameSink*> sinks;                   // outlive the fusion
  std::function<void(const std::string&)> notify;  // a line for a person; may be empty
};

struct BoardCounts {
  std::uint64_t used = 0;
  std::array<std::uint64_t, kUnpairedCount> unpaired{};
};

class Fusion final : public FrameSink {
 public:
  // Data's time: a board that is so far behind the newest frame is not waited for.
  static constexpr std::int64_t kPatience = 500'000'000;
  static constexpr std::size_t kMaxBoards = 32;

  explicit Fusion(FusionOptions options) : options_(std::move(options)) {}

  [[nodiscard]] Outcome<void> write(const proto::BootId& from, std::uint64_t sequence,
                                    const proto::CoefficientFrame& frame) override;
  [[nodiscard]] Outcome<void> flush() override { return {}; }
  // Fuses what waits.
  [[nodiscard]] Outcome<void> finish() override;

  [[nodiscard]] std::uint64_t fused() const { return next_; }
  [[nodiscard]] const std::map<std::string, BoardCounts>& counts() const { return counts_; }
  [[nodiscard]] const BoardWatch& watch() const { return watch_; }
  // A line for each board, for the end of a run.
  [[nodiscard]] std::vector<std::string> summary() const;

 private:
  struct Board {
    std::uint32_t bit = 0;
    std::uint64_t boot = 0;
    BoardInFusion stated;
    dsp::SurfaceModel<double> model;
    BoardArea area;
    float refractive_index = 1;
    double level_mm = 0;    // common frame, of its last surface
    double clock_sd_s = 0;  // of its last surface
    std::optional<BoardMap> map;
    BoardTrack track;
    std::optional<Unpaired> told;  // a reason that a person has been told
  };

  Board* board_of(const proto::BootId& from, const proto::CoefficientFrame& frame);
  static void take_model(Board& board, const proto::CoefficientFrame& frame);
  void leave_out(const std::string& name, Board& board, Unpaired cause);
  [[nodiscard]] bool is_heard(const Board& board) const;
  void choose_common();
  void choose_reference();
  [[nodiscard]] bool can_fuse(std::int64_t time_ns) const;
  [[nodiscard]] Outcome<void> fuse_ready(bool all);
  [[nodiscard]] Outcome<void> fuse_at(std::int64_t time_ns);
  [[nodiscard]] std::vector<Part> parts_at(std::int64_t time_ns);
  [[nodiscard]] Outcome<void> emit(std::int64_t time_ns, const std::vector<Part>& parts, bool consistent);
  [[nodiscard]] TimeTolerance tolerance() const;
  void tell(const BoardWatch::Event& event) const;

  FusionOptions options_;
  std::optional<dsp::SurfaceModel<double>> common_;
  std::map<std::string, Board> boards_;
  std::map<std::string, BoardCounts> counts_;
  BoardWatch watch_;
  std::string reference_;  // the board whose frames are the moments
  std::int64_t newest_ns_ = 0, first_ns_ = 0, fused_ns_ = 0;
  Eigen::VectorXd last_;  // coefficients of the last fused surface
  std::uint64_t next_ = 0, contradictory_ = 0;
};

}  // namespace srd::host
