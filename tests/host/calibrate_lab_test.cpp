// SPDX-License-Identifier: Apache-2.0
// srd calibrate on the published images of 2017, as a person runs it.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>

#include "drivers/geometry/calibration.hpp"
#include "host/calibrate/calibration.hpp"
#include "host/calibrate/outputs.hpp"

namespace srd::host {
namespace {

namespace fs = std::filesystem;

class SlowCalibrateLab : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    const char* data = std::getenv("SRD_DATA");
    const fs::path folder = fs::path(data != nullptr ? data : "../shared/data") / "opensrd-2017";
    if (!fs::exists(folder / "Settings_calib_CAM1.xml")) return;
    CalibrateOptions options;
    options.sources = {folder / "Settings_calib_CAM1.xml"};
    auto plan = plan_calibration(options);
    ASSERT_TRUE(plan.ok()) << plan.error().text();
    plan_ = *plan;
    auto result = calibrate(plan_, nullptr);
    ASSERT_TRUE(result.ok()) << result.error().text();
    result_ = std::make_unique<CalibrationResult>(std::move(*result));
  }
  static void TearDownTestSuite() { result_.reset(); }
  void SetUp() override {
    if (!result_) GTEST_SKIP() << "no opensrd-2017 in SRD_DATA";
  }
  [[nodiscard]] static const bundle::CameraFit& fit() { return result_->fit; }

  static inline CalibratePlan plan_;
  static inline std::unique_ptr<CalibrationResult> result_;
};

// The numbers of the 20 images of this calibration, of which these are 15, by mrcal 2.2 with the bend: fx 3708, cx 957.
TEST_F(SlowCalibrateLab, AgreesWithTwentyImages) {
  EXPECT_EQ(plan_.calibration_name, "Calib_CAM1.yml");
  EXPECT_EQ(result_->views.size(), 15u);
  EXPECT_LE(fit().rms_px, 0.12);
  EXPECT_NEAR(fit().intrinsics[2], 957, 25);
  EXPECT_LT(std::abs(fit().intrinsics[0] - 3708), 3 * fit().deviation(0));
  EXPECT_LT(std::abs(fit().intrinsics[2] - 957), 3 * fit().deviation(2));
  // -0.135 and -0.033 mm there, away from the camera counted.
  EXPECT_LT(std::abs(fit().bend[1] - 0.135), 3 * fit().deviation(fit().board_at() + 1));
  EXPECT_LT(std::abs(fit().bend[0] - 0.033), 3 * fit().deviation(fit().board_at()));
  EXPECT_LT(fit().deviation(0), 20);  // and not by errors that are too wide to be wrong
  EXPECT_LT(fit().deviation(2), 40);
}

TEST_F(SlowCalibrateLab, HalvesAgreeWithinTheirErrors) {
  ASSERT_TRUE(result_->check.even && result_->check.odd);
  EXPECT_TRUE(result_->check.halves_agree()) << result_->check.halves;
  for (const std::size_t i : {0U, 2U}) {
    const auto& a = *result_->check.even;
    const auto& b = *result_->check.odd;
    const double apart = std::abs(a.intrinsics[i] - b.intrinsics[i]);
    EXPECT_LT(apart, 3 * std::hypot(a.deviation(static_cast<int>(i)), b.deviation(static_cast<int>(i)))) << i;
  }
}

TEST_F(SlowCalibrateLab, AFlatBoardIsToldNotToFit) {
  CalibratePlan flat = plan_;
  flat.camera.surface = bundle::Surface::kFlat;
  const auto result = calibrate_boards(flat, result_->sighted, {});
  ASSERT_TRUE(result.ok()) << result.error().text();
  EXPECT_FALSE(result->check.fits);
  EXPECT_TRUE(result->check.bend_missing());
  ASSERT_FALSE(result->warnings.empty());
  EXPECT_EQ(result->warnings.front().find("The model does not fit: the board is bent"), 0u) << result->warnings.front();
}

TEST_F(SlowCalibrateLab, WritesWhatIsReadAgain) {
  const fs::path out = fs::path(::testing::TempDir()) / "srd_calibrate_lab";
  fs::remove_all(out);
  const CalibrationFiles files = calibration_files(out, plan_.calibration_name);
  ASSERT_TRUE(prepare_folder(out, files, false).ok());
  const auto written = write_results(out, files, *result_);
  ASSERT_TRUE(written.ok()) << written.error().text();
  const auto read = read_calibration(files.calibration);
  ASSERT_TRUE(read.ok()) << read.error().text();
  EXPECT_EQ(read->image_width, result_->width);
  EXPECT_EQ(read->distortion, std::vector<double>(fit().intrinsics.begin() + 4, fit().intrinsics.end()));
  EXPECT_EQ(read->camera.fx(), fit().intrinsics[0]);
  for (const char* name :
       {"report.toml", "corners.csv", "calibration.html", "uncertainty.png", "residuals.png", "views.png", "undistorted.png"})
    EXPECT_GT(fs::file_size(out / name), 1000u) << name;
  EXPECT_FALSE(prepare_folder(out, files, false).ok());
  fs::remove_all(out);
}

// The same corners with another zoom from the ninth image on. These views contradict each other by more than their noise, so a
// change has to be larger to be told than of a stiff board.
TEST_F(SlowCalibrateLab, AZoomThatIsChangedAmongTheseImagesIsRefused) {
  for (const double part : {0.1, -0.1}) {
    std::vector<SightedBoard> boards = result_->sighted;
    for (std::size_t i = 8; i < boards.size(); ++i)
      for (bundle::ViewCorner& corner : boards[i].view.corners)
        corner.pixel = (1 + part) * corner.pixel - part * Eigen::Vector2d(957, 570);
    const auto refused = calibrate_boards(plan_, std::move(boards), {});
    ASSERT_FALSE(refused.ok()) << part;
    const std::string text = refused.error().text();
    EXPECT_NE(text.find("zoom or focus was changed"), std::string::npos) << text;
    EXPECT_NE(text.find(part > 0 ? "longer" : "shorter"), std::string::npos) << text;
  }
}

}  // namespace
}  // namespace srd::host
