// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera/simulator/scene.hpp"

#include <gtest/gtest.h>

#include "drivers/camera/simulator/renderer.hpp"
#include "drivers/geometry/calibration.hpp"
#include "drivers/geometry/points.hpp"
#include "drivers/geometry/pose.hpp"
#include "drivers/recording/truth.hpp"
#include "drivers/support/text_file.hpp"
#include "tests/fakes/scratch_folder.hpp"

namespace srd {
namespace {

TEST(Scene, BuiltInFlumeIsWhatTheBarsDescribe) {
  const Scene& scene = default_scene();
  EXPECT_EQ(scene.width(), 1280);
  EXPECT_EQ(scene.height(), 640);
  EXPECT_EQ(scene.calibration.camera.fx(), 2150);
  EXPECT_EQ(scene.calibration.distortion, (std::vector<double>{-0.21, 0.09, -0.004, -0.0035, 0.3}));
  EXPECT_NEAR(scene.pose.centre().z(), 950, 1e-9);
  EXPECT_EQ(scene.points().size(), 11U * 21U);
  EXPECT_EQ(scene.points()[22], dsp::Vec3<double>(20, 20, 0));
  EXPECT_EQ(scene.surface.modes, dsp::ModeList::standard(5).value());
  EXPECT_EQ(scene.rate_hz, 50);
  EXPECT_EQ(scene.frames, 60);
}

TEST(Scene, BuiltInFlumeShowsEveryCornerInEveryFrame) {
  const Scene& scene = default_scene();
  for (std::uint64_t frame = 0; frame < 60; ++frame) {
    const auto pixels = truth_pixels(scene, frame);
    ASSERT_TRUE(pixels);
    for (const auto& pixel : *pixels) {
      EXPECT_GT(pixel.x(), 30);
      EXPECT_LT(pixel.x(), 1249);
      EXPECT_GT(pixel.y(), 30);
      EXPECT_LT(pixel.y(), 609);
    }
    // X runs with v, Y with u.
    EXPECT_GT((*pixels)[20].x(), (*pixels)[0].x() + 500);
    EXPECT_GT((*pixels)[210].y(), (*pixels)[0].y() + 250);
  }
}

TEST(Scene, EachModeMovesAsTold) {
  const auto scene = parse_scene(
      "[camera]\nrate_hz = 8.0\n[[surface.mode]]\nname = \"A00\"\nmean_mm = 50.0\n"
      "amplitude_mm = 2.0\nfrequency_hz = 1.0\nphase_deg = 90.0\n"
      "[[surface.mode]]\nname = \"A12\"\namplitude_mm = 1.0\nfrequency_hz = 2.0\n",
      "two modes");
  ASSERT_TRUE(scene) << scene.error().text();
  EXPECT_EQ(scene->surface.modes.size(), 2);
  EXPECT_NEAR(scene->coefficients(0)[0], 52, 1e-12);
  EXPECT_NEAR(scene->coefficients(2)[0], 50, 1e-12);
  EXPECT_NEAR(scene->coefficients(4)[0], 48, 1e-12);
  EXPECT_NEAR(scene->coefficients(1)[1], 1, 1e-12);
  EXPECT_EQ(scene->time_ns(3), 375'000'000);
  // A day later as exact as at the start.
  EXPECT_NEAR(scene->coefficients(8 * 86400)[0], 52, 1e-6);
}

TEST(Scene, LookAtPutsTheTargetInTheMiddleWithYToTheRight) {
  const dsp::Vec3<double> centre(-200, 250, 950), target(113, 208, 0);
  const auto pose = look_at(centre, target, 0);
  ASSERT_TRUE(pose);
  EXPECT_LT((pose->centre() - centre).norm(), 1e-9);
  const dsp::View<double> view{dsp::CameraModel<double>{}, *pose};
  EXPECT_LT(view.normalised(target)->norm(), 1e-12);
  EXPECT_GT(view.normalised(target + dsp::Vec3<double>(0, 10, 0))->x(), 0);
  EXPECT_NEAR(pose->rotation(0, 1), (pose->rotation.col(1).norm()) * std::sqrt(1 - std::pow(pose->rotation(2, 1), 2)), 1e-12);
  EXPECT_GT(view.normalised(target + dsp::Vec3<double>(10, 0, 0))->y(), 0);
  // Turned clockwise by a quarter, what lay to the right lies up.
  const dsp::View<double> turned{dsp::CameraModel<double>{}, look_at(centre, target, M_PI / 2).value()};
  EXPECT_LT(turned.normalised(target + dsp::Vec3<double>(0, 10, 0))->y(), 0);
  EXPECT_FALSE(look_at({0, 0, 0}, {0, 10, 0}, 0));
}

TEST(Scene, PoseMayBeGivenAsMatrixAndIndexAsTemperature) {
  const auto scene = parse_scene(
      "[pose]\nrotation = [0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0]\n"
      "translation_mm = [-200.0, -100.0, 900.0]\n"
      "[tank]\nwater_temperature_c = 20.0\nsalinity_per_mille = 0.0\nwavelength_nm = 589.0\n"
      "[[tank.plate]]\nthickness_mm = 10.0\nrefractive_index = 1.49\n",
      "matrix");
  ASSERT_TRUE(scene) << scene.error().text();
  EXPECT_LT((scene->pose.centre() - dsp::Vec3<double>(100, 200, 900)).norm(), 1e-9);
  EXPECT_NEAR(scene->media.water, 1.3330, 5e-5);  // check value of optics (21)
  EXPECT_EQ(scene->media.n_layers, 1);
  EXPECT_EQ(scene->media.layers[0].index, 1.49);
}

TEST(Scene, WrongFilesAreRefusedWithTheirLine) {
  const struct {
    const char* text;
    const char* found;
  } cases[] = {
      {"a = [", "scene.toml:1"},
      {"seed = 1\n\ncolour = 3\n", "scene.toml:3: unknown key 'colour'"},
      {"frames = 0\n", "scene.toml:1: key 'frames'"},
      {"frames = 2.5\n", "scene.toml:1: key 'frames'"},
      {"[camera]\nfx = -3.0\n", "scene.toml:2: key 'camera.fx'"},
      {"[camera]\nfx = nan\n", "scene.toml:2: key 'camera.fx'"},
      {"[camera]\ndistortion = [1.0, 2.0, 3.0]\n", "scene.toml:2: key 'camera.distortion'"},
      {"[camera]\nwidth = 4000000000\n", "scene.toml:2: key 'camera.width'"},
      {"[pose]\nroll_deg = 3.0\n", "key 'pose.centre_mm' is missing"},
      {"[pose]\ncentre_mm = [0.0, 0.0]\ntarget_mm = [1.0, 0.0, 0.0]\n", "scene.toml:2: key 'pose.centre_mm'"},
      {"[pose]\ncentre_mm = [0.0, 0.0, 0.0]\ntarget_mm = [0.0, 5.0, 0.0]\n", "scene.toml:3: key 'pose.target_mm'"},
      {"[pose]\ncentre_mm = [0.0, 0.0, -900.0]\ntarget_mm = [5.0, 5.0, 0.0]\n", "scene.toml:2: key 'pose.centre_mm'"},
      {"[pose]\nrotation = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0]\ntranslation_mm = [0.0, 0.0, "
       "900.0]\n",
       "scene.toml:2: key 'pose.rotation'"},
      {"[pose]\nroll_deg = 1.0\nrotation = [1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0]\n"
       "translation_mm = [0.0, 0.0, 900.0]\n",
       "scene.toml:2: key 'pose.roll_deg'"},
      {"[pattern]\norigin_square = \"black\"\n", "scene.toml:2: key 'pattern.origin_square'"},
      {"[tank]\nrefractive_index = 1.33\nwater_temperature_c = 20.0\n", "scene.toml:3: key 'tank.water_temperature_c'"},
      {"[tank]\nwater_temperature_c = 20.0\n", "key 'tank.wavelength_nm' is missing"},
      {"[tank]\nwater_temperature_c = 35.0\nsalinity_per_mille = 0.0\nwavelength_nm = 589.0\n",
       "scene.toml:2: key 'tank.water_temperature_c'"},
      {"[tank]\nplate = 3\n", "scene.toml:2: key 'tank.plate'"},
      {"[[surface.mode]]\nmean_mm = 80.0\n", "name' is missing"},
      {"[[surface.mode]]\nname = \"D\"\n", "scene.toml:2"},
      {"[[surface.mode]]\nname = \"A00\"\nmean_mm = 80.0\n[[surface.mode]]\nname = \"A00\"\n", "different modes"},
      {"[[surface.mode]]\nname = \"A00\"\nmean_mm = 2.0\namplitude_mm = 3.0\n", "water above the pattern"},
      {"[light]\ndark = 100.0\nbright = 90.0\n", "scene.toml:2: key 'light.dark'"},
      {"[image]\nblur_px = 0.1\n", "scene.toml:2: key 'image.blur_px'"},
      {"[image]\npixel = \"square\"\nblur_px = 0.1\n", "scene.toml:3: key 'image.blur_px'"},
      {"[image]\npixel = \"round\"\n", "scene.toml:2: key 'image.pixel'"},
      {"[image]\nsharpen_amount = 4.0\n", "scene.toml:2: key 'image.sharpen_amount'"},
      {"[[glare]]\nradius_px = 0.0\n", "scene.toml:2"},
      {"camera = 3\n", "scene.toml:1: key 'camera'"},
  };
  for (const auto& wrong : cases) {
    const auto scene = parse_scene(wrong.text, "scene.toml");
    ASSERT_FALSE(scene) << wrong.text;
    EXPECT_EQ(scene.error().exit, Exit::kUsage);
    EXPECT_NE(scene.error().text().find(wrong.found), std::string::npos) << wrong.text << scene.error().text();
  }
  EXPECT_FALSE(read_scene("no/such/scene.toml"));
}

// Another program's truth: pixels of a scene from its coefficients and pose, index 1.336.
TEST(Optics, AgreesWithAnIndependentRayTracer) {
  const std::filesystem::path root = fakes::lab_data() / "rendered";
  if (!std::filesystem::is_directory(root)) GTEST_SKIP() << "no lab recordings: set SRD_DATA to their folder";
  const struct {
    const char* folder;
    int parameters, camera;
  } cases[] = {{"p1_5term", 5, 1}, {"p2_8term_2cam", 8, 1}, {"p2_8term_2cam", 8, 2}};
  for (const auto& one : cases) {
    const auto folder = root / one.folder;
    const std::string n = std::to_string(one.camera);
    const auto calibration = read_calibration(folder / "PRE_PROCESS" / ("Calib_CAM" + n + ".yml"));
    const auto pose = read_pose(folder / ("truth_pose_" + n + ".yml"));
    const auto points = read_points(folder / "PRE_PROCESS/FeaturesF.txt");
    ASSERT_TRUE(calibration && pose && points);
    const dsp::View<double> view{calibration->camera, *pose};
    const dsp::SurfaceModel<double> model{dsp::ModeList::standard(one.parameters).value(), 240, 440, 0, 0};
    dsp::Media<double> media;
    media.water = 1.336;
    const std::string truth = read_text_file(folder / "truth.csv", "truth").value();
    const std::string pixels = read_text_file(folder / ("truth_pixels_" + n + ".csv"), "pixels").value();
    const auto surface_lines = split_lines(truth), pixel_lines = split_lines(pixels);
    ASSERT_EQ(surface_lines.size(), pixel_lines.size());
    double worst = 0;
    for (std::size_t frame = 0; frame < surface_lines.size(); ++frame) {
      const auto numbers = split_commas(surface_lines[frame].text), uv = split_commas(pixel_lines[frame].text);
      ASSERT_EQ(uv.size(), 2 * points->size());
      dsp::Coefficients<double> a(one.parameters);
      for (int j = 0; j < one.parameters; ++j) a[j] = parse_number<double>(numbers[static_cast<std::size_t>(j)]).value();
      for (std::size_t i = 0; i < points->size(); ++i) {
        dsp::Trace<double> traced;
        dsp::Mat2<double> by_xy;
        const auto xy = dsp::see_through(view, model, a, media, (*points)[i], *view.normalised((*points)[i]), traced, by_xy);
        ASSERT_TRUE(xy);
        const dsp::Vec2<double> expected(parse_number<double>(uv[2 * i]).value(), parse_number<double>(uv[2 * i + 1]).value());
        worst = std::max(worst, (view.camera.pixel(*xy) - expected).cwiseAbs().maxCoeff());
      }
    }
    std::printf("  %s camera %d: %.1e px at most\n", one.folder, one.camera, worst);
    EXPECT_LT(worst, 1e-4);
  }
}

}  // namespace
}  // namespace srd
