// SPDX-License-Identifier: Apache-2.0
// srd rig-check: small moves are told, and none where nothing has moved.
#include <gtest/gtest.h>

#include "drivers/camera/simulator/scene.hpp"
#include "host/rig_check/rig_check.hpp"
#include "tests/fakes/scratch_folder.hpp"
#include "tests/fakes/synthetic_scene.hpp"
#include "tests/host/scene_picture.hpp"

namespace srd::host {
namespace {

namespace fs = std::filesystem;

class RigOfFlume : public testing::Test {
 protected:
  fakes::ScratchFolder folder_;
  Scene scene_ = default_scene();

  void SetUp() override { (void)write_calibration(folder_.path() / "calibration.yml", scene_.calibration); }
  void render(const char* name, const dsp::Pose<double>& pose, std::uint64_t seed, double noise, bool dry = true) {
    Scene scene = scene_;
    scene.pose = pose;
    scene.seed = seed;
    scene.noise = noise;
    (void)write_gray_image(folder_.path() / name, fakes::picture_of(scene, dry).view(), 1);
  }
  [[nodiscard]] RigRequest request() const {
    RigRequest request;
    request.reference.references = {folder_.path() / "before.png"};
    request.reference.calibration = folder_.path() / "calibration.yml";
    request.reference.board = PatternSize{11, 21};
    request.reference.square_mm = 20;
    request.reference.order.position = 1;
    request.reference.search = {5, 200, 8};
    request.later = {folder_.path() / "after.png"};
    request.reference.water.media = request.later_water.media = scene_.media;
    return request;
  }
};

TEST_F(RigOfFlume, ATurnOfAFiftiethOfADegreeAndAShiftOfATenthOfAMillimetreAreTold) {
  for (int axis = 0; axis < 6; ++axis) {
    const double size = axis < 3 ? 0.02 * fakes::kPi / 180 : 0.1;
    render("before.png", scene_.pose, 1, 4);
    render("after.png", dsp::changed(scene_.pose, size * dsp::PoseChange::Unit(axis)), 2, 4);
    const auto found = check_rig(request());
    ASSERT_TRUE(found) << found.error().text();
    EXPECT_TRUE(found->moved) << axis << "\n" << rig_text(*found, request());
    EXPECT_NEAR(found->poses.change[axis], size, 4 * std::sqrt(found->poses.covariance(axis, axis))) << axis;
  }
}

TEST_F(RigOfFlume, NothingIsToldWhereNothingHasMoved) {
  int significant = 0;
  for (std::uint64_t pair = 0; pair < 8; ++pair) {
    const double noise = 1 + static_cast<double>(pair % 4);
    render("before.png", scene_.pose, 2 * pair + 10, noise);
    render("after.png", scene_.pose, 2 * pair + 11, noise);
    const auto found = check_rig(request());
    ASSERT_TRUE(found);
    EXPECT_FALSE(found->moved) << rig_text(*found, request());
    EXPECT_NEAR(found->poses.variance_factor, 1, 0.4) << noise;
    significant += found->poses.by_chance < 0.01 ? 1 : 0;
  }
  EXPECT_LE(significant, 1);
}

TEST_F(RigOfFlume, ThroughStillWaterTooWithItsLevel) {
  scene_.surface.modes = dsp::ModeList::standard(1).value();
  scene_.motions = {{dsp::Mode{}, 80, 0, 0, 0}};
  render("before.png", scene_.pose, 1, 2);
  RigRequest wet = request();
  wet.later_water.level_mm = 80.05;
  wet.later_water.level_deviation_mm = 0.05;
  render("after.png", scene_.pose, 2, 2, false);
  const auto still = check_rig(wet);
  ASSERT_TRUE(still) << still.error().text();
  EXPECT_FALSE(still->moved) << rig_text(*still, wet);
  render("after.png", dsp::changed(scene_.pose, 0.0005 * dsp::PoseChange::Unit(2)), 2, 2, false);
  const auto turned = check_rig(wet);
  ASSERT_TRUE(turned);
  EXPECT_TRUE(turned->moved) << rig_text(*turned, wet);
  EXPECT_NEAR(turned->turn_deg, 0.0005 * 180 / fakes::kPi, 4 * turned->turn_deviation_deg);
}

}  // namespace
}  // namespace srd::host
