// SPDX-License-Identifier: Apache-2.0
#include "drivers/geometry/calibration.hpp"
#include "drivers/geometry/points.hpp"
#include "drivers/geometry/pose.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

#include "tests/fakes/scratch_folder.hpp"

namespace srd {
namespace {

using fakes::ScratchFolder;

std::string matrix(const std::string& key, int rows, int columns, const std::string& numbers) {
  return key + ": !!opencv-matrix\n   rows: " + std::to_string(rows) + "\n   cols: " + std::to_string(columns) +
         "\n   dt: d\n   data: [ " + numbers + " ]\n";
}
const std::string kHead = "%YAML:1.0\n---\n";
const std::string kGoodCamera = matrix("camera_matrix", 3, 3, "2150., 0., 640.5, 0., 2156., 320., 0., 0., 1.");
const std::string kGoodDistortion = matrix("distortion_coefficients", 5, 1, "-0.21, 0.09, -0.004, -0.0035, 0.3");

TEST(Rig, CalibrationComesBackAsWritten) {
  const ScratchFolder folder;
  for (const std::size_t n : {0U, 4U, 5U, 8U, 12U, 14U}) {
    Calibration written;
    for (std::size_t i = 0; i < n; ++i) written.distortion.push_back(0.1 / 3 - 0.017 * static_cast<double>(i));
    written.camera = dsp::CameraModel<double>::make(2150 + 1.0 / 3, 2156.7, 640.1, 319.9, written.distortion).value();
    written.image_width = n == 4 ? 0 : 1280;
    written.image_height = n == 4 ? 0 : 640;
    const auto file = folder.path() / "calibration.yml";
    ASSERT_TRUE(write_calibration(file, written));
    const auto read = read_calibration(file);
    ASSERT_TRUE(read) << read.error().text();
    EXPECT_EQ(read->camera.fx(), written.camera.fx());
    EXPECT_EQ(read->camera.cy(), written.camera.cy());
    EXPECT_EQ(read->camera.distortion(), written.camera.distortion());
    if (n > 0) {
      EXPECT_EQ(read->distortion, written.distortion);
    }
    EXPECT_EQ(read->image_width, written.image_width);
    EXPECT_EQ(read->image_height, written.image_height);
  }
}

TEST(Rig, PoseComesBackAsWritten) {
  const ScratchFolder folder;
  dsp::Pose<double> written;
  written.rotation = (Eigen::AngleAxisd(2.9, Eigen::Vector3d(1, 0.1, -0.2).normalized())).toRotationMatrix();
  written.translation = {-210.64612480405040, 1.0 / 3, 937.83014874040487};
  ASSERT_TRUE(write_pose(folder.path() / "pose.yml", written));
  const auto read = read_pose(folder.path() / "pose.yml");
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(read->rotation, written.rotation);
  EXPECT_EQ(read->translation, written.translation);
}

TEST(Rig, NearRotationIsMadeOrthonormal) {
  const ScratchFolder folder;
  const auto file =
      folder.write("pose.yml", kHead + matrix("Rotationmatrix", 3, 3, "1.0003, 0, 0, 0, 0.9998, 0.0002, 0, 0, 1") +
                                   matrix("TranslationVector", 1, 3, "1, 2, 3"));
  const auto read = read_pose(file);
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_LT((read->rotation * read->rotation.transpose() - dsp::Mat3<double>::Identity()).norm(), 1e-15);
  EXPECT_EQ(read->translation, dsp::Vec3<double>(1, 2, 3));
}

TEST(Rig, PointsComeBackAsWritten) {
  const ScratchFolder folder;
  const Points written{{0, 0, 0}, {1.0 / 3, -20.5, 1e-7}, {1e5, 3, 0}};
  ASSERT_TRUE(write_points(folder.path() / "points.txt", written));
  const auto read = read_points(folder.path() / "points.txt");
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(*read, written);
}

TEST(Rig, PointsMayHaveCommentsCommasTabsAndWindowsLineEnds) {
  const ScratchFolder folder;
  const auto file = folder.write("points.txt", "\xEF\xBB\xBF# x y z\r\n0\t20\t0\r\n\r\n1, 2, 3 # corner\r\n 4;5;+6");
  const auto read = read_points(file);
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(*read, (Points{{0, 20, 0}, {1, 2, 3}, {4, 5, 6}}));
}

struct Wrong {
  std::string contents;
  std::string expected_in_text;  // key or line, and what is wrong
};

TEST(Rig, WrongCalibrationIsRefusedWithFileAndKey) {
  const ScratchFolder folder;
  const Wrong cases[] = {
      {"", "calibration"},
      {"hello", "calibration"},
      {kHead, "camera"},
      {std::string("%YAML:1.0\n\0\0", 12), "calibration"},
      {kHead + "camera_matrix: [ [ [", "calibration"},
      {kHead + "camera_matrix: " + std::string(100000, '[') + "\n", "calibration"},
      {kHead + kGoodDistortion, "camera_matrix"},
      {kHead + kGoodCamera, "distortion_coefficients"},
      {kHead + "camera_matrix: 5\n" + kGoodDistortion, "camera_matrix"},
      {kHead + "camera_matrix: [ 1, 2, 3 ]\n" + kGoodDistortion, "camera_matrix"},
      {kHead + matrix("camera_matrix", 3, 3, "2150., 0., 640., 0., 2150., 320., 0., 0.") + kGoodDistortion, "camera_matrix"},
      {kHead + matrix("camera_matrix", 1000000, 1000000, "1.") + kGoodDistortion, "camera_matrix"},
      {kHead + matrix("camera_matrix", -3, -3, "1.,2.,3.,4.,5.,6.,7.,8.,9.") + kGoodDistortion, "camera_matrix"},
      {kHead + matrix("camera_matrix", 1, 9, "2150., 0., 640., 0., 2150., 320., 0., 0., 1.") + kGoodDistortion,
       "camera_matrix"},
      {kHead + matrix("camera_matrix", 3, 3, ".Nan, 0., 640., 0., 2150., 320., 0., 0., 1.") + kGoodDistortion, "camera_matrix"},
      {kHead + matrix("camera_matrix", 3, 3, "2150., 0., 640., 0., -2150., 320., 0., 0., 1.") + kGoodDistortion,
       "camera_matrix"},
      {kHead + matrix("camera_matrix", 3, 3, "2150., 3., 640., 0., 2150., 320., 0., 0., 1.") + kGoodDistortion,
       "camera_matrix"},
      {kHead + kGoodCamera + matrix("distortion_coefficients", 6, 1, "1,2,3,4,5,6"), "distortion_coefficients"},
      {kHead + kGoodCamera + matrix("distortion_coefficients", 2, 2, "1,2,3,4"), "distortion_coefficients"},
      {kHead + kGoodCamera + matrix("distortion_coefficients", 4, 1, "1,2,.Inf,4"), "distortion_coefficients"},
      {kHead + kGoodCamera + kGoodDistortion + "image_width: -5\n", "image_width"},
      {kHead + kGoodCamera + kGoodDistortion + "image_height: tall\n", "image_height"},
  };
  for (const Wrong& wrong : cases) {
    const auto file = folder.write("calib.yml", wrong.contents);
    const auto read = read_calibration(file);
    ASSERT_FALSE(read) << wrong.contents.substr(0, 300);
    const std::string text = read.error().text();
    EXPECT_EQ(read.error().exit, Exit::kInput);
    EXPECT_NE(text.find(file.string()), std::string::npos) << text;
    EXPECT_NE(text.find(wrong.expected_in_text), std::string::npos) << text;
    EXPECT_FALSE(read.error().expected.empty()) << text;
  }
  EXPECT_FALSE(read_calibration(folder.path() / "none.yml"));
  EXPECT_FALSE(read_calibration(folder.path()));
}

TEST(Rig, LensOfAnotherFormulaIsRefusedByItsName) {
  const ScratchFolder folder;
  const auto file = folder.path() / "calibration.yml";
  const auto distortion = [](int n) {
    std::string numbers = "0.01";
    for (int i = 1; i < n; ++i) numbers += ", 0.01";
    return matrix("distortion_coefficients", 1, n, numbers);
  };
  struct Case {
    std::string line;
    int n;
    std::string said;  // empty: taken
  };
  const std::vector<Case> cases = {
      {"distortion_model: plumb_bob", 5, ""},
      {"distortion_model: \"plumb_bob\"", 4, ""},
      {"distortion_model: radtan", 4, ""},
      {"distortion_model: Brown Conrady", 5, ""},
      {"distortion_model: rational_polynomial", 8, ""},
      {"distortion_model: rational-polynomial", 14, ""},
      {"distortion_model: thin_prism", 12, ""},
      {"distortion_model: tilted", 14, ""},
      {"camera_model: pinhole", 4, ""},
      {"fisheye_model: 0", 5, ""},
      {"distortion_model: equidistant", 4, "'equidistant'"},
      {"distortion_model: equi", 4, "'equi'"},
      {"distortion_model: fisheye", 4, "'fisheye'"},
      {"distortion_model: kannala_brandt4", 4, "'kannala_brandt4'"},
      {"distortion_model: inverse_brown_conrady", 5, "'inverse_brown_conrady'"},
      {"distortion_model: thin_prism_fisheye", 12, "'thin_prism_fisheye'"},
      {"distortion_model: \"\"", 4, "''"},
      {"distortion_model: [ plumb_bob ]", 4, "not a name"},
      {"distortion_model: plumb_bob", 8, "4 or 5 coefficients"},
      {"distortion_model: rational_polynomial", 5, "8 or 12 or 14 coefficients"},
      {"distortion_model: tilted", 12, "14 coefficients"},
      {"camera_model: omni", 4, "'omni'"},
      {"model_type: KANNALA_BRANDT", 4, "'KANNALA_BRANDT'"},
      {"fisheye_model: 1", 4, "fisheye"},
      {"xi: 1.2", 4, "omnidirectional"},
  };
  for (const Case& c : cases) {
    folder.write("calibration.yml", kHead + kGoodCamera + distortion(c.n) + c.line + "\n");
    const auto read = read_calibration(file);
    if (c.said.empty()) {
      ASSERT_TRUE(read) << c.line << "\n" << read.error().text();
      EXPECT_EQ(read->distortion.size(), static_cast<std::size_t>(c.n));
      continue;
    }
    ASSERT_FALSE(read) << c.line << " with " << c.n;
    const std::string said = read.error().text();
    EXPECT_EQ(read.error().exit, Exit::kInput);
    EXPECT_NE(said.find(c.line.substr(0, c.line.find(':'))), std::string::npos) << said;
    EXPECT_NE(said.find(c.said), std::string::npos) << said;
  }
}

TEST(Rig, WrongPoseIsRefusedWithFileAndKey) {
  const ScratchFolder folder;
  const std::string rotation = matrix("Rotationmatrix", 3, 3, "1,0,0,0,-1,0,0,0,-1");
  const std::string translation = matrix("TranslationVector", 3, 1, "0., 0., 950.");
  ASSERT_TRUE(read_pose(folder.write("pose.yml", kHead + rotation + translation)));
  const Wrong cases[] = {
      {kHead + translation, "Rotationmatrix"},
      {kHead + rotation, "TranslationVector"},
      {kHead + matrix("Rotationmatrix", 3, 3, "1,0,0,0,1,0,0,0,-1") + translation, "determinant"},
      {kHead + matrix("Rotationmatrix", 3, 3, "1,0,0,0,1.002,0,0,0,1") + translation, "Rotationmatrix"},
      {kHead + matrix("Rotationmatrix", 3, 1, "0,0,1") + translation, "Rotationmatrix"},
      {kHead + rotation + matrix("TranslationVector", 4, 1, "1,2,3,4"), "TranslationVector"},
      {kHead + rotation + matrix("TranslationVector", 3, 1, "1,2,1e300"), "TranslationVector"},
  };
  for (const Wrong& wrong : cases) {
    const auto file = folder.write("pose.yml", wrong.contents);
    const auto read = read_pose(file);
    ASSERT_FALSE(read) << wrong.contents;
    const std::string text = read.error().text();
    EXPECT_NE(text.find(file.string()), std::string::npos) << text;
    EXPECT_NE(text.find(wrong.expected_in_text), std::string::npos) << text;
  }
}

TEST(Rig, WrongPointsAreRefusedWithTheirLine) {
  const ScratchFolder folder;
  const Wrong cases[] = {
      {"", "holds no points"},
      {"# nothing\n\n", "holds no points"},
      {"0 0 0\n1 2\n", ":2"},
      {"0 0 0\n1 2 3 4\n", ":2"},
      {"0 0 0\n\n1 two 3\n", ":3"},
      {"0 0 nan\n", ":1"},
      {"0 0 inf\n", ":1"},
      {"0 0 1e400\n", ":1"},
      {"1 2 3\n0 0 0\n1.0 2 3\n", ":3"},
      {"0 0 0\n-0 0 0\n", "line 1"},
      {"1e9 0 0\n", ":1"},
      {"0x1 0 0\n", ":1"},
  };
  for (const Wrong& wrong : cases) {
    const auto read = read_points(folder.write("points.txt", wrong.contents));
    ASSERT_FALSE(read) << wrong.contents;
    EXPECT_NE(read.error().text().find(wrong.expected_in_text), std::string::npos) << read.error().text();
  }
}

TEST(Rig, NothingIsWrittenWhereNothingCanBe) {
  const ScratchFolder folder;
  const auto nowhere = folder.path() / "no" / "such" / "folder.yml";
  EXPECT_FALSE(write_pose(nowhere, {}));
  EXPECT_FALSE(write_points(nowhere, {{0, 0, 0}}));
  EXPECT_FALSE(write_calibration(nowhere, {}));
}

// Any change to a file gives a value or a problem: no exception, no crash (the sanitizer build sees more).
TEST(Rig, DamagedFilesNeverThrow) {
  const ScratchFolder folder;
  const std::string good = kHead + "calibration_time: \"Mon\"\nimage_width: 1280\n" + kGoodCamera + kGoodDistortion;
  ASSERT_TRUE(read_calibration(folder.write("calib.yml", good)));
  std::mt19937 random(5);
  int refused = 0;
  for (std::size_t cut = 0; cut < good.size(); cut += 3)
    refused += read_calibration(folder.write("calib.yml", good.substr(0, cut))).ok() ? 0 : 1;
  EXPECT_GT(refused, static_cast<int>(good.size()) / 3 - 20);
  for (int i = 0; i < 2000; ++i) {
    std::string bad = good;
    const int changes = 1 + static_cast<int>(random() % 4);
    for (int j = 0; j < changes; ++j) {
      const std::size_t at = random() % bad.size();
      switch (random() % 3) {
        case 0: bad[at] = static_cast<char>(random() % 256); break;
        case 1: bad.erase(at, 1 + random() % 8); break;
        default: bad.insert(at, std::string(1 + random() % 3, "[]{}:-,. \n!%&*\"'<>"[random() % 19])); break;
      }
    }
    EXPECT_NO_THROW((void)read_calibration(folder.write("calib.yml", bad)));
  }
}

TEST(Rig, ReadsTheFilesOfTheLab) {
  const std::filesystem::path root = fakes::lab_data();
  if (!std::filesystem::is_directory(root)) GTEST_SKIP() << "no lab recordings: set SRD_DATA to their folder";
  for (const char* name : {"opensrd-2017/INPUT/Calib_CAM1.yml", "opensrd-2017/published/Calib_CAM1.yml",
                           "opensrd-2016/INPUT/Calib_C1.yml", "rendered/p2_8term_2cam/PRE_PROCESS/Calib_CAM2.yml"}) {
    const auto calibration = read_calibration(root / name);
    ASSERT_TRUE(calibration) << calibration.error().text();
    EXPECT_GT(calibration->camera.fx(), 1000) << name;
  }
  for (const char* name : {"opensrd-2017/INPUT/Camera_Pose_1.txt", "opensrd-2016/published/Camera_Pose_1.txt",
                           "rendered/p2_8term_2cam/truth_pose_2.yml"}) {
    const auto pose = read_pose(root / name);
    ASSERT_TRUE(pose) << pose.error().text();
    EXPECT_GT(pose->centre().z(), 100) << name;
  }
  for (const char* name : {"opensrd-2017/INPUT/VerticesPoseEstimation_CAM1.txt", "opensrd-2016/INPUT/FeaturesF_1.txt",
                           "rendered/p1_5term/PRE_PROCESS/FeaturesF.txt"}) {
    const auto points = read_points(root / name);
    ASSERT_TRUE(points) << points.error().text();
    EXPECT_GE(points->size(), 85U) << name;
  }
}

}  // namespace
}  // namespace srd
