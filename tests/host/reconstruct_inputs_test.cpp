// SPDX-License-Identifier: Apache-2.0
// What srd reconstruct says of inputs that cannot be used.
#include <gtest/gtest.h>

#include "drivers/recording/image_file.hpp"
#include "tests/host/opensrd_folder.hpp"

namespace srd::host {
namespace {

struct WrongInput {
  const char* name;
  void (*spoil)(OpenSrdFolder&);
  int exit;
  std::vector<const char*> said;
};

void PrintTo(const WrongInput& wrong, std::ostream* out) { *out << wrong.name; }

// Features and poses from images instead of files.
void from_images(OpenSrdFolder& lab) {
  lab.keys["TypeFeatureInput"] = "1";
  lab.keys["ResponseRadius"] = "5";
  lab.keys["ResponseThreshold"] = "350";
  lab.keys["MinDistance"] = "15";
  lab.keys["InputDirectory1"] = "\"IMAGES\"";
}
void pose_from_image(OpenSrdFolder& lab) {
  from_images(lab);
  lab.keys["TypeCameraPose"] = "1";
  lab.keys["RefPatternSize_Width"] = "11";
  lab.keys["RefPatternSize_Height"] = "21";
  lab.keys["InputInitial1"] = "\"FeaturesF_1.txt\"";
  lab.keys["InputReference1"] = "\"REF1.png\"";
}
void grey_image(OpenSrdFolder& lab, const std::string& name, int width = 1280, int height = 640) {
  std::filesystem::create_directories((lab.path() / name).parent_path());
  const std::vector<std::uint8_t> pixels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 128);
  EXPECT_TRUE(write_gray_image(lab.path() / name, {pixels.data(), width, height, width}));
}
void replace_in(OpenSrdFolder& lab, const std::string& name, const std::string& what, const std::string& with) {
  std::string text = fakes::bytes_of(lab.path() / name);
  const std::size_t at = text.find(what);
  ASSERT_NE(at, std::string::npos) << what;
  lab.write(name, text.replace(at, what.size(), with));
}

class ReconstructInputs : public testing::TestWithParam<WrongInput> {};

TEST_P(ReconstructInputs, AreRefusedWithTheirNameAndWhatWasExpected) {
  OpenSrdFolder lab(fakes::flume_scene(5, 1));
  for (int frame = 0; frame < 2; ++frame) lab.add_frame(fakes::wavy(5));
  GetParam().spoil(lab);
  const CommandResult done = lab.run();
  EXPECT_EQ(done.exit, GetParam().exit) << done.err;
  for (const char* part : GetParam().said) EXPECT_NE(done.err.find(part), std::string::npos) << part << " in:\n" << done.err;
  // A run that ended leaves its summary, which says why no frame has a surface; others leave nothing.
  EXPECT_EQ(std::filesystem::exists(lab.out()), done.err.find("summary.txt") != std::string::npos);
}

const std::string kFirst = OpenSrdFolder::feature_file(0, 0);

INSTANTIATE_TEST_SUITE_P(
    Reconstruct, ReconstructInputs,
    testing::Values(
        WrongInput{"NoCalibration",
                   [](OpenSrdFolder& l) { std::filesystem::remove(l.path() / "INPUT/Calib_C1.yml"); },
                   3,
                   {"Calib_C1.yml", "no such file"}},
        WrongInput{"CalibrationWithoutMatrix",
                   [](OpenSrdFolder& l) { l.write("INPUT/Calib_C1.yml", "%YAML:1.0\n---\na: 1\n"); },
                   3,
                   {"Calib_C1.yml", "camera_matrix"}},
        WrongInput{
            "NoPose", [](OpenSrdFolder& l) { l.keys["InputReference1"] = "\"none.txt\""; }, 3, {"none.txt", "no such file"}},
        WrongInput{
            "NoPoints", [](OpenSrdFolder& l) { l.keys["InputFeatures1"] = "\"none.txt\""; }, 3, {"none.txt", "no such file"}},
        WrongInput{"PointTwice",
                   [](OpenSrdFolder& l) { replace_in(l, "INPUT/FeaturesF_1.txt", "0 20 0", "0 0 0"); },
                   3,
                   {"FeaturesF_1.txt:", "repeats a point"}},
        WrongInput{"WrongNumberOfPoints",
                   [](OpenSrdFolder& l) { l.keys["FeaturePatternSize_Height"] = "17"; },
                   3,
                   {"FeaturesF_1.txt", "187: 11 rows of 17", "231"}},
        WrongInput{"NoFrames",
                   [](OpenSrdFolder& l) { l.keys["InputDirectory1"] = "\"DATA/NONE\""; },
                   3,
                   {"DATA/NONE", "no such folder"}},
        WrongInput{"NoFeatureFileAmongFiles",
                   [](OpenSrdFolder& l) {
                     l.write("DATA/OTHER/a.png", "");
                     l.keys["InputDirectory1"] = "\"DATA/OTHER\"";
                   },
                   3,
                   {"DATA/OTHER", "holds no frames", "1 other file"}},
        WrongInput{"FeatureThatDoesNotExist",
                   [](OpenSrdFolder& l) { l.write(kFirst, "0 100 100\n231 5 5\n"); },
                   3,
                   {"f0000.txt:2", "0 to 230", "231"}},
        WrongInput{"NegativeId", [](OpenSrdFolder& l) { l.write(kFirst, "-1 100 100\n"); }, 3, {"f0000.txt:1", "-1"}},
        WrongInput{"FeatureTwice", [](OpenSrdFolder& l) { l.write(kFirst, "4 1 1\n\n4 2 2\n"); }, 3, {"f0000.txt:3", "line 1"}},
        WrongInput{"FeatureNotANumber", [](OpenSrdFolder& l) { l.write(kFirst, "0 nan 100\n"); }, 3, {"f0000.txt:1", "nan"}},
        WrongInput{"FeatureWithoutV", [](OpenSrdFolder& l) { l.write(kFirst, "0 100\n"); }, 3, {"f0000.txt:1", "id u v"}},
        WrongInput{"NothingFitsTheModel",
                   [](OpenSrdFolder& l) {
                     for (std::size_t frame = 0; frame < 2; ++frame)
                       l.write(OpenSrdFolder::feature_file(0, frame), "0 100 100\n");
                   },
                   3,
                   {"no frame gave a surface", "2 too_few_corners"}},
        WrongInput{"NoImages", [](OpenSrdFolder& l) { from_images(l); }, 3, {"IMAGES", "no such folder"}},
        WrongInput{"UnreadableImage",
                   [](OpenSrdFolder& l) {
                     from_images(l);
                     l.write("IMAGES/a.png", "not an image");
                   },
                   3,
                   {"a.png"}},
        WrongInput{"ImageOfAnotherSize",
                   [](OpenSrdFolder& l) {
                     from_images(l);
                     grey_image(l, "IMAGES/a.png", 640, 480);
                   },
                   3,
                   {"a.png", "1280 x 640", "640 x 480"}},
        WrongInput{"NoPatternInAnyImage",
                   [](OpenSrdFolder& l) {
                     from_images(l);
                     grey_image(l, "IMAGES/a.png");
                     grey_image(l, "IMAGES/b.png");
                   },
                   3,
                   {"no frame gave a surface", "2 searching"}},
        WrongInput{"NoReferenceImage", [](OpenSrdFolder& l) { pose_from_image(l); }, 3, {"REF1.png", "no such file"}},
        WrongInput{"NoBoardInTheReference",
                   [](OpenSrdFolder& l) {
                     pose_from_image(l);
                     grey_image(l, "INPUT/REF1.png");
                   },
                   3,
                   {"INPUT/REF1.png", "shows no board", "11 rows of 21", "0 corners"}},
        WrongInput{"ReferenceOfAnotherSize",
                   [](OpenSrdFolder& l) {
                     pose_from_image(l);
                     grey_image(l, "INPUT/REF1.png", 100, 100);
                   },
                   3,
                   {"REF1.png", "1280 x 640"}},
        WrongInput{"WrongSetting", [](OpenSrdFolder& l) { l.keys["Lx"] = "-1"; }, 2, {"settings.xml:", "'Lx'"}},
        WrongInput{"TwoResultsInOneFile",
                   [](OpenSrdFolder& l) { l.keys["OutputFileNameResiudals"] = "\"Coefficients.txt\""; },
                   2,
                   {"share a file"}}),
    [](const auto& named) { return std::string(named.param.name); });

TEST(ReconstructArguments, WrongOnesAreRefused) {
  OpenSrdFolder lab(fakes::flume_scene(5, 1));
  lab.add_frame(fakes::wavy(5));
  const std::vector<std::vector<std::string>> wrong = {{"--refractive-index", "0.9"},
                                                       {"--refractive-index", "1"},
                                                       {"--refractive-index", "nan"},
                                                       {"--metric", "best"},
                                                       {"--rate", "0"},
                                                       {"--rate", "-5"},
                                                       {"--lx", "240"},
                                                       {"--model", "4"},
                                                       {"--model", "5"},
                                                       {"--modes", "A00,B"},
                                                       {"--guess", "70"},
                                                       {"--features", "none"},
                                                       {"--bogus"}};
  for (const auto& arguments : wrong) {
    const CommandResult done = lab.run(arguments);
    EXPECT_NE(done.exit, 0) << arguments[0];
    EXPECT_FALSE(std::filesystem::exists(lab.out())) << arguments[0];
    EXPECT_NE(done.err, "") << arguments[0];
  }
  EXPECT_EQ(run_command({(lab.path() / "settings.xml").string()}).exit, 2);  // --out is missing
  EXPECT_EQ(run_command({(lab.path() / "none.xml").string(), "--out", lab.out().string()}).exit, 3);
}

TEST(ReconstructArguments, ARecordingNeedsItsModel) {
  OpenSrdFolder lab(fakes::flume_scene(5, 1));
  grey_image(lab, "recording/a.png");
  std::filesystem::copy(lab.path() / "INPUT/Calib_C1.yml", lab.path() / "recording/calibration.yml");
  std::filesystem::copy(lab.path() / "INPUT/Pose_1.txt", lab.path() / "recording/pose.yml");
  std::filesystem::copy(lab.path() / "INPUT/FeaturesF_1.txt", lab.path() / "recording/points.txt");
  const std::vector<std::string> source = {(lab.path() / "recording").string(), "--out", lab.out().string()};
  const auto run = [&](std::vector<std::string> more) {
    more.insert(more.begin(), source.begin(), source.end());
    return run_command(more);
  };
  EXPECT_NE(run({}).err.find("--lx"), std::string::npos);
  EXPECT_NE(run({"--lx", "240", "--ly", "440"}).err.find("--guess"), std::string::npos);
  EXPECT_NE(run({"--lx", "240", "--ly", "440", "--guess", "80", "--modes", "A00,Q"}).err.find("A00,Q"), std::string::npos);
  EXPECT_NE(run({"--lx", "240", "--ly", "440", "--guess", "80,0,0,0,0,0"}).err.find("1 to 5"), std::string::npos);
  const CommandResult blank = run({"--lx", "240", "--ly", "440", "--guess", "80"});
  EXPECT_EQ(blank.exit, 3);
  EXPECT_NE(blank.err.find("1 searching"), std::string::npos) << blank.err;
}

}  // namespace
}  // namespace srd::host
