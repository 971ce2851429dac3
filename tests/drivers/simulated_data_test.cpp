// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "drivers/camera/simulator/renderer.hpp"
#include "drivers/recording/recording.hpp"
#include "drivers/recording/truth.hpp"
#include "tests/fakes/test_data.hpp"

namespace srd {
namespace {

TEST(SimulatedData, IsWhatItsSceneRenders) {
  for (const char* name : {"flume-small", "pair-camera-1", "pair-camera-2"}) {
    const auto folder = fakes::test_data() / name;
    const auto scene = read_scene(folder / "scene.toml");
    ASSERT_TRUE(scene) << scene.error().text();
    auto renderer = Renderer::make(*scene);
    ASSERT_TRUE(renderer) << renderer.error().text();
    const auto recording = read_recording(folder);
    ASSERT_TRUE(recording) << recording.error().text();
    ASSERT_EQ(recording->frames.size(), static_cast<std::size_t>(scene->frames));
    const auto truth = read_truth(folder / kTruthName);
    ASSERT_TRUE(truth) << truth.error().text();
    GrayImage image{std::vector<std::uint8_t>(640 * 320), 640, 320};
    const GrayBuffer buffer{image.pixels.data(), 640, 320, 640};
    for (const std::size_t i : {std::size_t{0}, recording->frames.size() - 1}) {
      renderer->render(i, buffer);
      EXPECT_EQ(read_gray_image(folder / recording->frames[i].file)->pixels, image.pixels) << name << " " << i;
      EXPECT_LT((truth->rows[i].coefficients - scene->coefficients(i)).norm(), 1e-9) << name << " " << i;
    }
    renderer->render_reference(buffer);
    EXPECT_EQ(read_gray_image(folder / kReferenceName)->pixels, image.pixels) << name;
  }
}

}  // namespace
}  // namespace srd
