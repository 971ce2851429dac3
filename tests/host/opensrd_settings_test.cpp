// SPDX-License-Identifier: Apache-2.0
#include "host/opensrd/settings.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/fakes/scratch_folder.hpp"
#include "tests/host/opensrd_folder.hpp"

namespace srd::host::opensrd {
namespace {

using fakes::ScratchFolder;

Keys keys_guide() {
  return {{"CameraAmount", "2"},
          {"InputTypeRef", "1"},
          {"InputType", "1"},
          {"saveErrors", "1"},
          {"saveFeatureCoordinates", "0"},
          {"saveCameraPose", "1"},
          {"showCorners", "0"},
          {"InputInitial", "\"PRE_PROCESS/FeaturesF.txt\""},
          {"InputDirectory1", "\"DATA/CAM1\""},
          {"InputDirectory2", "\"DATA/CAM2\""},
          {"InputReference1", "\"ref1.png\""},
          {"InputReference2", "\"ref2.png\""},
          {"CalibrationFile1", "\"Calib1.yml\""},
          {"CalibrationFile2", "\"Calib2.yml\""},
          {"Position1", "1"},
          {"Position2", "3"},
          {"OutputFileName", "\"RESULTS/coeffs.txt\""},
          {"OutputFileNameErrors", "\"RESULTS/errors.txt\""},
          {"OutputCameraPose1", "\"RESULTS/pose1.txt\""},
          {"OutputCameraPose2", "\"RESULTS/pose2.txt\""},
          {"SurfaceModel", "8"},
          {"Square_Size", "15"},
          {"Lx", "40"},
          {"Ly", "160"},
          {"Initialguess", "\"[70.0]\""},
          {"Scaling", "\"[1.0,10,10,10,10,10,10,10]\""},
          {"BoardSize_Width", "9"},
          {"BoardSize_Height", "14"},
          {"PatternSize_Width", "5"},
          {"PatternSize_Height", "17"},
          {"ResponseThreshold", "350"},
          {"MinDistance", "15"},
          {"responseRadius", "10"},
          {"MatchesThreshold", "12"},
          {"ErrorMetric", "1"},
          {"epsg", "0.000001"},
          {"epsf", "0"},
          {"epsx", "0"},
          {"maxits", "7"},
          {"diffStep", "0.01"}};
}

Keys keys_2017() {
  return {{"NumberOfCameras", "1"},
          {"TypeCameraPose", "0"},
          {"InputDirectory1", "\"DATA/CAM1\""},
          {"InputReference1", "\"INPUT/pose.txt\""},
          {"CalibrationFile1", "\"INPUT/Calib_CAM1.yml\""},
          {"OutputFileName", "\"RESULTS/TimeSeries.txt\""},
          {"OutputFileCenters", "\"RESULTS/Centres.txt\""},
          {"Lx", "100"},
          {"Ly", "100"},
          {"gridSize", "10"},
          {"MinDistance", "18"},
          {"ResponseRadius", "5"},
          {"ResponseThreshold", "400"},
          {"min_u", "1300"},
          {"max_u", "1550"},
          {"min_v", "100"},
          {"max_v", "300"},
          {"minThreshold", "90"},
          {"maxThreshold", "95"},
          {"InitialGuess", "\"[77.00,-3.5000]\""},
          {"SurfaceModelParameters", "3"},
          {"Scaling", "\"[1.0,1.0]\""}};
}

Outcome<Settings> read(const ScratchFolder& folder, const Keys& keys) {
  return read_settings(folder.write("settings.xml", settings_text(keys)));
}

Settings good(const ScratchFolder& folder, const Keys& keys) {
  auto settings = read(folder, keys);
  EXPECT_TRUE(settings) << settings.error().text();
  return settings.ok() ? *settings : Settings{};
}

TEST(OpenSrdSettings, ReadsTheGuidesDialect) {
  const ScratchFolder folder;
  const Settings s = good(folder, keys_guide());
  EXPECT_EQ(s.dialect, Dialect::kGuide);
  ASSERT_EQ(s.cameras.size(), 2U);
  EXPECT_EQ(s.cameras[1].position, 3);
  EXPECT_EQ(s.cameras[0].feature_points, folder.path() / "PRE_PROCESS/FeaturesF.txt");
  EXPECT_EQ(s.cameras[1].feature_points, s.cameras[0].feature_points);
  EXPECT_TRUE(s.cameras[0].pose_points.empty());
  EXPECT_EQ(s.board.rows, 9);
  EXPECT_EQ(s.board.columns, 14);
  EXPECT_EQ(s.pattern.count(), 85);
  EXPECT_EQ(s.square_mm, 15);
  EXPECT_EQ(s.parameters, 8);
  EXPECT_EQ(s.metric, dsp::Metric::kCollinearity);
  EXPECT_EQ(s.scale[7], 10);
  EXPECT_EQ(s.response_radius, 10);
  EXPECT_EQ(s.match_radius_px, 12);
  EXPECT_EQ(s.epsg, 1e-6);
  EXPECT_EQ(s.max_iterations, 7);
  EXPECT_FALSE(s.save_features);
  EXPECT_EQ(s.coefficients_output, "RESULTS/coeffs.txt");
  EXPECT_TRUE(s.warnings.empty());
}

TEST(OpenSrdSettings, ReadsTheDialectOf2016) {
  const ScratchFolder folder;
  const Settings s = good(folder, keys_2016(3, 5));
  EXPECT_EQ(s.dialect, Dialect::k2016);
  ASSERT_EQ(s.cameras.size(), 3U);
  EXPECT_EQ(s.cameras[2].feature_points, folder.path() / "FeaturesF_3.txt");
  EXPECT_FALSE(s.pose_from_image);
  EXPECT_FALSE(s.features_from_images);
  EXPECT_EQ(s.metric, dsp::Metric::kDisparity);
  EXPECT_EQ(s.errors_output, "Errors.txt");
}

TEST(OpenSrdSettings, ReadsTheDialectOf2017AndLetsTheGuessDecideItsLength) {
  const ScratchFolder folder;
  const Settings s = good(folder, keys_2017());
  EXPECT_EQ(s.dialect, Dialect::k2017);
  EXPECT_EQ(s.parameters, 2);
  EXPECT_EQ(s.guess, (std::vector<double>{77, -3.5}));
  EXPECT_EQ(s.cameras[0].region.u0, 1300);
  EXPECT_EQ(s.cameras[0].region.v1, 300);
  EXPECT_EQ(s.patch.bright_above, 95);
  ASSERT_EQ(s.warnings.size(), 1U);
  EXPECT_NE(s.warnings[0].find("SurfaceModelParameters"), std::string::npos) << s.warnings[0];
}

TEST(OpenSrdSettings, QuotesBlanksAndCaseDoNotMatter) {
  const ScratchFolder folder;
  Keys keys = keys_2016(1, 5);
  keys["CalibrationFile1"] = "\n    My camera.yml  ";
  keys["InputFeatures1"] = "\"my points.txt\"";
  keys["Lx"] = " 240. ";
  keys["InitialGuess"] = "[70.0,0.5]";
  keys["Scaling"] = "\"[1, 1.0 ,1,1 , 2]\"";
  keys.erase("ThreadAmount");
  keys["threadamount"] = "3";
  const Settings s = good(folder, keys);
  EXPECT_EQ(s.cameras.at(0).calibration, folder.path() / "My camera.yml");
  EXPECT_EQ(s.cameras.at(0).feature_points, folder.path() / "my points.txt");
  EXPECT_EQ(s.lx, 240);
  EXPECT_EQ(s.guess.at(1), 0.5);
  EXPECT_EQ(s.scale.at(4), 2);
  EXPECT_TRUE(s.warnings.empty());
}

TEST(OpenSrdSettings, AShortGuessIsFilledWithZeros) {
  const ScratchFolder folder;
  EXPECT_EQ(good(folder, keys_guide()).guess, (std::vector<double>{70, 0, 0, 0, 0, 0, 0, 0}));
}

TEST(OpenSrdSettings, LooksInTheFoldersOf2016WhenAFileIsNotWhereItIsNamed) {
  const ScratchFolder folder;
  folder.write("INPUT/Calib_C1.yml", "");
  folder.write("RESULTS/Pose_1.txt", "");
  folder.write("FeaturesF_1.txt", "");
  folder.write("INPUT/FeaturesF_1.txt", "");
  const Settings s = good(folder, keys_2016(1, 5));
  EXPECT_EQ(s.cameras.at(0).calibration, folder.path() / "INPUT/Calib_C1.yml");
  EXPECT_EQ(s.cameras.at(0).reference, folder.path() / "RESULTS/Pose_1.txt");
  EXPECT_EQ(s.cameras.at(0).feature_points, folder.path() / "FeaturesF_1.txt");  // as named comes first
  Keys keys = keys_2016(1, 5);
  keys["CalibrationFile1"] = "\"/nowhere/Calib.yml\"";
  EXPECT_EQ(good(folder, keys).cameras.at(0).calibration, "/nowhere/Calib.yml");
}

TEST(OpenSrdSettings, PathsWrittenOnWindowsAreFound) {
  const ScratchFolder folder;
  folder.write("calibration/left/Calib_C1.yml", "");
  Keys keys = keys_2016(1, 5);
  keys["CalibrationFile1"] = "\"calibration\\left\\Calib_C1.yml\"";
  keys["OutputFileName"] = "\"RESULTS\\coeffs.txt\"";
  const Settings s = good(folder, keys);
  EXPECT_EQ(s.cameras.at(0).calibration, folder.path() / "calibration/left/Calib_C1.yml");
  EXPECT_EQ(s.coefficients_output, "RESULTS/coeffs.txt");
}

TEST(OpenSrdSettings, AnUnknownKeyIsIgnoredWithAWarningThatNamesKeyAndLine) {
  const ScratchFolder folder;
  Keys keys = keys_2016(1, 5);
  keys["Aperture"] = "2.8";
  const std::string text = settings_text(keys);
  const auto inside = read_settings(folder.write(
      "settings.xml", std::string(text).replace(text.find("<Settings>"), 10, "<Settings>\n<!-- <Aperture>1</Aperture> -->")));
  ASSERT_TRUE(inside) << inside.error().text();
  ASSERT_EQ(inside->warnings.size(), 1U);
  EXPECT_NE(inside->warnings[0].find("settings.xml:5: unknown key 'Aperture'"), std::string::npos) << inside->warnings[0];
}

TEST(OpenSrdSettings, AskingForWindowsIsAWarning) {
  const ScratchFolder folder;
  Keys keys = keys_2016(1, 5);
  keys["ShowCorners"] = "1";
  ASSERT_EQ(good(folder, keys).warnings.size(), 1U);
}

struct WrongValue {
  const char* key;
  const char* value;  // nullptr: the key is left out
  const char* expected;
};

class WrongSetting : public testing::TestWithParam<WrongValue> {};

TEST_P(WrongSetting, NamesFileLineKeyAndWhatWasExpected) {
  const WrongValue& wrong = GetParam();
  const ScratchFolder folder;
  Keys keys = keys_2016(2, 5);
  keys["TypeFeatureInput"] = "1";
  keys["ResponseRadius"] = "5";
  keys["ResponseThreshold"] = "350";
  keys["MinDistance"] = "15";
  ASSERT_TRUE(read(folder, keys));
  if (wrong.value == nullptr)
    keys.erase(wrong.key);
  else
    keys[wrong.key] = wrong.value;
  const auto settings = read(folder, keys);
  ASSERT_FALSE(settings) << wrong.key;
  EXPECT_EQ(settings.error().exit, Exit::kUsage);
  const std::string text = settings.error().text();
  EXPECT_NE(text.find("settings.xml"), std::string::npos) << text;
  EXPECT_NE(text.find(wrong.key), std::string::npos) << text;
  EXPECT_NE(text.find(wrong.expected), std::string::npos) << text;
  if (wrong.value != nullptr && *wrong.value != '\0') {
    EXPECT_NE(text.find("settings.xml:"), std::string::npos) << text;
  }
}

INSTANTIATE_TEST_SUITE_P(
    OpenSrdSettings, WrongSetting,
    testing::Values(
        WrongValue{"NumberOfCameras", "0", "from 1 to 3"}, WrongValue{"NumberOfCameras", "4", "from 1 to 3"},
        WrongValue{"NumberOfCameras", nullptr, "missing"}, WrongValue{"NumberOfCameras", "1.5", "whole number"},
        WrongValue{"CalibrationFile2", nullptr, "missing"}, WrongValue{"CalibrationFile2", "\"\"", "double quotes"},
        WrongValue{"InputDirectory1", nullptr, "folder of images"}, WrongValue{"Lx", "-40", "1e+06 (mm)"},
        WrongValue{"Lx", "0", "mm"}, WrongValue{"Ly", "nan", "a number"}, WrongValue{"Ly", ".Nan", "a number"},
        WrongValue{"Ly", ".Inf", "a number"}, WrongValue{"Ly", "160 mm", "a number"}, WrongValue{"Ly", "", "a number"},
        WrongValue{"SurfaceModelParameters", "4", "1, 3, 5, 8 or 12"}, WrongValue{"SurfaceModelParameters", "13", "1 to 12"},
        WrongValue{"InitialGuess", "\"[70,0,0,0,0,0]\"", "at most 5"}, WrongValue{"InitialGuess", "\"[]\"", "list"},
        WrongValue{"InitialGuess", "\"[70,nan]\"", "list"}, WrongValue{"InitialGuess", "\"[70,0\"", "list"},
        WrongValue{"InitialGuess", nullptr, "missing"}, WrongValue{"Scaling", "\"[1,1,1]\"", "5 numbers"},
        WrongValue{"Scaling", "\"[1,1,0,1,1]\"", "above 0"}, WrongValue{"Scaling", "\"[1,1,-1,1,1]\"", "above 0"},
        WrongValue{"ErrorMetric", "3", "from 1 to 2"}, WrongValue{"ErrorMetric", nullptr, "collinearity"},
        WrongValue{"Epsg", "-1", "from 0"}, WrongValue{"MaxIts", "-5", "from 0"}, WrongValue{"MaxIts", "2.5", "whole number"},
        WrongValue{"TypeFeatureInput", "2", "0 or 1"}, WrongValue{"FeaturePatternSize_Width", "1", "from 2"},
        WrongValue{"FeaturePatternSize_Height", nullptr, "missing"}, WrongValue{"ResponseRadius", "7", "5 or 10"},
        WrongValue{"ResponseThreshold", "0", "from 1"}, WrongValue{"MinDistance", nullptr, "missing"},
        WrongValue{"OutputFileName", nullptr, "missing"}, WrongValue{"OutputFileNameResiudals", nullptr, "missing"},
        WrongValue{"OutputDirectory2", nullptr, "features are to be saved"}, WrongValue{"InputFeatures2", nullptr, "missing"}));

TEST(OpenSrdSettings, AllProblemsAreToldAtOnce) {
  const ScratchFolder folder;
  Keys keys = keys_2016(1, 5);
  keys["Lx"] = "-1";
  keys["Ly"] = "-2";
  keys.erase("OutputFileName");
  const auto settings = read(folder, keys);
  ASSERT_FALSE(settings);
  const std::string text = settings.error().text();
  for (const char* part : {"3 problems", "'Lx'", "'Ly'", "'OutputFileName' is missing"})
    EXPECT_NE(text.find(part), std::string::npos) << text;
}

TEST(OpenSrdSettings, PositionsAreOneToFour) {
  const ScratchFolder folder;
  for (const char* position : {"0", "5", "left"}) {
    Keys keys = keys_guide();
    keys["Position2"] = position;
    const auto settings = read(folder, keys);
    ASSERT_FALSE(settings);
    EXPECT_NE(settings.error().text().find("Position2"), std::string::npos) << settings.error().text();
  }
}

TEST(OpenSrdSettings, WhatIsNoSettingsFileIsSaid) {
  const ScratchFolder folder;
  for (const char* text : {"", "hello", "%YAML:1.0\na: 1\n", "<opencv_storage></opencv_storage>",
                           "<?xml version=\"1.0\"?><opencv_storage><Settings><Lx>4</Ly></Settings></opencv_storage>",
                           "<?xml version=\"1.0\"?><opencv_storage><Settings>5</Settings></opencv_storage>",
                           "<?xml version=\"1.0\"?><opencv_storage><Settings><A>\"open</A></Settings>"}) {
    const auto settings = read_settings(folder.write("settings.xml", text));
    ASSERT_FALSE(settings) << text;
    EXPECT_EQ(settings.error().exit, Exit::kUsage) << text;
    EXPECT_NE(settings.error().text().find("settings.xml"), std::string::npos);
  }
  const auto unquoted = read_settings(folder.write("settings.xml", settings_text({{"A", "1"}, {"B", "[70.0, 0.5]"}})));
  ASSERT_FALSE(unquoted);
  EXPECT_NE(unquoted.error().text().find("settings.xml:5"), std::string::npos) << unquoted.error().text();
  const auto missing = read_settings(folder.path() / "none.xml");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().exit, Exit::kInput);
}

TEST(OpenSrdSettings, SettingsOfACalibrationAreRecognised) {
  const ScratchFolder folder;
  const auto settings = read(folder, {{"Write_outputFileName", "\"Calib.yml\""}, {"nframes", "20"}});
  ASSERT_FALSE(settings);
  EXPECT_NE(settings.error().text().find("srd calibrate"), std::string::npos) << settings.error().text();
}

TEST(OpenSrdSettings, DamagedFilesNeverThrow) {
  const ScratchFolder folder;
  const std::string whole = settings_text(keys_2016(1, 5));
  std::mt19937 random(3);
  int refused = 0;
  for (int i = 0; i < 300; ++i) {
    std::string bad = whole;
    for (int change = 0; change < 3; ++change) {
      const std::size_t at = random() % bad.size();
      switch (random() % 3) {
        case 0: bad[at] = static_cast<char>(random() % 256); break;
        case 1: bad.erase(at, 1 + random() % 20); break;
        default: bad.insert(at, std::string(1 + random() % 3, "<>/\"&;-! 0"[random() % 10])); break;
      }
    }
    EXPECT_NO_THROW(refused += read_settings(folder.write("settings.xml", bad)).ok() ? 0 : 1);
  }
  EXPECT_GT(refused, 30);
}

}  // namespace
}  // namespace srd::host::opensrd
