// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera/simulator/scene.hpp"

namespace srd {

std::string_view default_scene_text() {
  return R"(# A flume from above: an oblique camera 0.95 m off, a checkerboard under 80 mm of water that moves by millimetres.
# Lengths mm, image px. X runs with the image's v (down), Y with its u (right), Z up to the camera; the pattern is Z = 0.
# A key that is left out has the value printed here.

name = "flume"
seed = 1          # of the noise: the same seed gives the same images on every machine
frames = 60
reference = true  # also the dry pattern: reference.png

[camera]
width = 1280
height = 640
fx = 2150.0
fy = 2150.0
cx = 646.8        # the centre of the top left pixel is (0, 0)
cy = 315.4
distortion = [-0.21, 0.09, -0.004, -0.0035, 0.3]  # OpenCV's k1 k2 p1 p2 k3 ..: 0, 4, 5, 8, 12 or 14 numbers
rate_hz = 50.0
exposure_us = 2000

[pose]            # or rotation = [nine numbers, row by row] and translation_mm = [three]: x_C = R X + T
centre_mm = [-200.0, 250.0, 950.0]
target_mm = [113.0, 208.0, 0.0]
roll_deg = 0.4    # clockwise, seen from behind the camera

[pattern]
rows = 11         # of inner corners: X = row * square_mm
columns = 21      #                   Y = column * square_mm
square_mm = 20.0
border_squares = 1       # squares beyond the outer inner corners
origin_square = "dark"   # the square between the corners (0, 0) and (1, 1): "dark" or "bright"
margin = 0.5             # what lies around the squares: 0 as dark as a dark square, 1 as bright as a bright one

[tank]
refractive_index = 1.333  # or water_temperature_c, salinity_per_mille and wavelength_nm
# [[tank.plate]]          # glass or acrylic on the pattern, from the top down
# thickness_mm = 10.0
# refractive_index = 1.49

[surface]         # height = sum of modes: A_mn cos(m pi X/Lx) cos(n pi Y/Ly), B X/Lx, C Y/Ly
lx_mm = 240.0
ly_mm = 440.0
origin_mm = [0.0, 0.0]

[[surface.mode]]  # mean + amplitude sin(2 pi frequency t + phase)
name = "A00"
mean_mm = 80.0
amplitude_mm = 3.0
frequency_hz = 0.31
phase_deg = 0.0

[[surface.mode]]
name = "B"
amplitude_mm = 3.0
frequency_hz = 0.83
phase_deg = 40.0

[[surface.mode]]
name = "C"
amplitude_mm = 3.0
frequency_hz = 1.13
phase_deg = 110.0

[[surface.mode]]
name = "A10"
amplitude_mm = 3.0
frequency_hz = 0.97
phase_deg = 200.0

[[surface.mode]]
name = "A01"
amplitude_mm = 3.0
frequency_hz = 1.37
phase_deg = 290.0

[light]
dark = 20.0       # grey levels at the image's centre
bright = 220.0
gradient_percent = 0.0        # change of brightness across the image
gradient_direction_deg = 0.0  # 0: brighter to the right, 90: brighter downwards
vignette_percent = 0.0        # fall of brightness at the image's corners

[image]
blur_px = 0.7     # standard deviation of the lens's blur, a normal distribution; what the pixel averages over comes on top
pixel = "normal"  # "normal": as a normal distribution of a square's variance, so that the whole blur is one of deviation
                  # sqrt(blur_px^2 + 1/12), for blur_px of at least 0.5; "square": the pixel's square itself, evenly, for
                  # blur_px of at least 0.2, and 9 to 25 times slower to render
noise = 1.5       # sigma of the sensor, grey levels
sharpen_amount = 0.0     # unsharp mask after the noise, as cameras' processors make it: level + amount (level - blurred level)
sharpen_radius_px = 1.0  # standard deviation of that blur, a normal distribution

# [[glare]]       # a light that the surface mirrors into the camera
# u_px = 400.0
# v_px = 300.0
# radius_px = 12.0      # sigma
# peak = 255.0          # grey levels on top
# speed_u_px_s = 60.0   # a spot that leaves the image comes in on the other side
# speed_v_px_s = 10.0
)";
}

}  // namespace srd
