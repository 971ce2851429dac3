// SPDX-License-Identifier: Apache-2.0
#include "firmware/config/node_config.hpp"

#include <gtest/gtest.h>

#include <tuple>

#include "firmware/config/instrument.hpp"
#include "tests/fakes/test_data.hpp"

namespace srd::firmware {
namespace {

constexpr const char* kMinimal = "[camera]\nsource = \"simulator\"\n[surface]\nguess_mm = [80]\n";

TEST(NodeConfig, FillsInDefaults) {
  const auto config = NodeConfig::parse(kMinimal, "node.toml");
  ASSERT_TRUE(config.ok()) << config.error().text();
  EXPECT_EQ(config->modes.size(), 5);
  EXPECT_EQ(config->guess, (std::vector<double>{80, 0, 0, 0, 0}));
  EXPECT_EQ(config->camera->kind, "simulator");
  EXPECT_EQ(config->pace, Pace::kCamera);
  EXPECT_TRUE(config->host.empty());
}

TEST(NodeConfig, TakesALoss) {
  for (const auto& [word, loss] :
       {std::pair{"none", dsp::Loss::kNone}, std::pair{"huber", dsp::Loss::kHuber}, std::pair{"tukey", dsp::Loss::kTukey}}) {
    const auto config = NodeConfig::parse(std::string(kMinimal) + "[estimator]\nloss = \"" + word + "\"\n", "node.toml");
    ASSERT_TRUE(config.ok()) << config.error().text();
    EXPECT_EQ(config->estimator.loss, loss);
  }
}

TEST(NodeConfig, AStoppingRuleLeavesTheOthersAsTheyAre) {
  using Rules = std::tuple<double, double, double, int>;
  for (const auto& [text, rules] : {std::pair<const char*, Rules>{"", {1e-9, 1e-3, 1e-9, 50}},
                                    {"max_iterations = 3\n", {1e-9, 1e-3, 1e-9, 3}},
                                    {"epsg = 1e-4\n", {1e-4, 1e-3, 1e-9, 50}},
                                    {"epsx = 1e-4\n", {1e-9, 1e-3, 1e-4, 50}},
                                    {"epsf = 0\n", {1e-9, 0, 1e-9, 50}}}) {
    const auto config = NodeConfig::parse(std::string(kMinimal) + "[estimator]\n" + text, "node.toml");
    ASSERT_TRUE(config.ok()) << config.error().text();
    const dsp::EstimatorOptions& e = config->estimator;
    EXPECT_EQ(Rules(e.epsg, e.epsf, e.epsx, e.max_iterations), rules) << text;
  }
}

struct Wrong {
  const char* text;
  std::vector<const char*> said;
};

TEST(NodeConfig, SaysWhatIsWrongWhere) {
  const std::vector<Wrong> cases{
      {"[surface]\nguess_mm = [80]\nrefractiv = 1\n", {"n.toml:3", "surface.refractiv", "unknown key"}},
      {"[surface]\nguess_mm = [80]\n[watr]\n", {"unknown key 'watr'"}},
      {"[surface]\nguess_mm = \"80\"\n", {"n.toml:2", "surface.guess_mm", "a list"}},
      {"[surface]\nguess_mm = [nan]\n", {"surface.guess_mm"}},
      {"[surface]\n", {"surface.guess_mm", "missing"}},
      {"[surface]\nguess_mm = [1, 2, 3, 4, 5, 6]\n", {"1 to 5 numbers", "found 6"}},
      {"[surface]\nparameters = 7\nguess_mm = [80]\n", {"1, 3, 5, 8 or 12", "found 7"}},
      {"[surface]\nmodes = [\"A00\", \"Q7\"]\nguess_mm = [80]\n", {"\"Q7\""}},
      {"[surface]\nmodes = [\"A00\", \"A00\"]\nguess_mm = [80]\n", {"different modes"}},
      {"[surface]\nguess_mm = [80]\nlx_mm = 0\n", {"surface.lx_mm", "from 0.001", "found 0"}},
      {"[surface]\nparameters = 1\nguess_mm = [80]\nlower_mm = [90]\nupper_mm = [70]\n", {"lower_mm", "above"}},
      {"[surface]\nguess_mm = [80]\nlower_mm = [1, 2]\n", {"lower_mm", "a list of 5"}},
      {"[surface]\nguess_mm = [80]\n[water]\nrefractive_index = 3\n", {"n.toml:4", "water.refractive_index"}},
      {"[surface]\nguess_mm = [80]\n[water]\nrefractive_index = 1.33\nwater_temperature_c = 20\n", {"both"}},
      {"[surface]\nguess_mm = [80]\n[[water.plate]]\nthickness_mm = 5\n", {"water.plate[0].index", "missing"}},
      {"[surface]\nguess_mm = [80]\n[camera]\nsource = \"usb:0\"\n", {"camera.source", "recording:FOLDER", "usb:0"}},
      {"[surface]\nguess_mm = [80]\n[camera]\nrate = \"fast\"\n", {"\"camera\", \"max\"", "fast"}},
      {"[surface]\nguess_mm = [80]\n[detector]\nradius_px = 7\n", {"5 or 10", "7"}},
      {"[surface]\nguess_mm = [80]\n[detector]\nregion_px = [10, 10, 5, 20]\n", {"region_px", "u0 < u1"}},
      {"[surface]\nguess_mm = [80]\n[pattern]\nrows = 5\n", {"pattern.columns", "pattern.square_mm", "missing"}},
      {"[surface]\nguess_mm = [80]\n[node]\nid = \"a b\"\n", {"node.id", "a b"}},
      {"[surface]\nguess_mm = [80]\n[node]\nid = \"1e5\"\n", {"node.id", "1e5", "a number", "flume-1e5"}},
      {"[surface]\nguess_mm = [80]\n[node]\nid = \"NA\"\n", {"node.id", "NA", "missing", "flume-NA"}},
      {"[surface]\nguess_mm = [80]\n[estimator]\nmetric = \"best\"\n", {"metric", "reprojection"}},
      {"[surface]\nguess_mm = [80]\n[estimator]\nloss = \"cauchy\"\n", {"n.toml:4", "estimator.loss", "huber", "cauchy"}},
      {"[surface]\nguess_mm = [80]\n[estimator]\ndeadline_us = 0\n", {"n.toml:4", "estimator.deadline_us", "from 1", "us"}},
      {"[surface\n", {"n.toml:1"}},
  };
  for (const Wrong& wrong : cases) {
    const auto config = NodeConfig::parse(wrong.text, "n.toml");
    ASSERT_FALSE(config.ok()) << wrong.text;
    EXPECT_EQ(config.error().exit, Exit::kUsage);
    for (const char* part : wrong.said)
      EXPECT_NE(config.error().text().find(part), std::string::npos) << "no \"" << part << "\" in: " << config.error().text();
  }
}

TEST(NodeConfig, ListsAllProblemsAtOnce) {
  const auto config = NodeConfig::parse("[surface]\nguess_mm = [80]\nlx_mm = -1\n[detector]\nthreshold = 0\n", "n.toml");
  ASSERT_FALSE(config.ok());
  EXPECT_NE(config.error().text().find("n.toml:3"), std::string::npos);
  EXPECT_NE(config.error().text().find("n.toml:5"), std::string::npos);
}

TEST(Instrument, TakesPlaceAndPatternFromARecording) {
  auto config = NodeConfig::parse("[surface]\nguess_mm = [80]\nlx_mm = 240\nly_mm = 440\n", "node.toml");
  ASSERT_TRUE(config.ok()) << config.error().text();
  config->camera = CameraSource{"recording", fakes::test_data().string() + "/flume-small"};
  const auto instrument = make_instrument(*config);
  ASSERT_TRUE(instrument.ok()) << instrument.error().text();
  EXPECT_EQ(instrument->width, 640);
  EXPECT_EQ(instrument->tracker->pattern().size(), 231);
}

TEST(Instrument, WarnsOfModesThatTheViewCannotSeparate) {
  // A wave of 4 km along X is level over the pattern.
  const auto summary = [](const std::string& surface) {
    const auto config =
        NodeConfig::parse("[camera]\nsource = \"simulator\"\n[surface]\nguess_mm = [80]\n" + surface, "node.toml");
    EXPECT_TRUE(config.ok()) << config.error().text();
    const auto instrument = make_instrument(*config);
    EXPECT_TRUE(instrument.ok()) << instrument.error().text();
    return instrument->summary;
  };
  const std::string bad = summary("lx_mm = 99999\nmodes = [\"A00\", \"A10\", \"A01\"]\n");
  EXPECT_NE(bad.find("the view cannot separate A10 from A00"), std::string::npos) << bad;
  const std::string good = summary("parameters = 12\n");
  EXPECT_EQ(good.find("warning"), std::string::npos) << good;
}

TEST(Instrument, WarnsOfCornersOutsideTheRegion) {
  const auto config = NodeConfig::parse(std::string(kMinimal) + "[detector]\nregion_px = [0, 0, 300, 300]\n", "node.toml");
  ASSERT_TRUE(config.ok()) << config.error().text();
  const auto instrument = make_instrument(*config);
  ASSERT_TRUE(instrument.ok()) << instrument.error().text();
  EXPECT_NE(instrument->summary.find("corners lie in the image or region"), std::string::npos) << instrument->summary;
}

TEST(Instrument, SaysWhichFileIsMissing) {
  auto config = NodeConfig::parse("[surface]\nguess_mm = [80]\nlx_mm = 240\nly_mm = 440\n", "node.toml");
  ASSERT_TRUE(config.ok());
  const auto no_camera = make_instrument(*config);
  ASSERT_FALSE(no_camera.ok());
  EXPECT_EQ(no_camera.error().exit, Exit::kUsage);
  config->camera = CameraSource{"recording", fakes::test_data().string() + "/flume-small"};
  config->calibration = "recording:elsewhere.yml";
  const auto instrument = make_instrument(*config);
  ASSERT_FALSE(instrument.ok());
  EXPECT_NE(instrument.error().text().find("elsewhere.yml"), std::string::npos);
}

}  // namespace
}  // namespace srd::firmware
