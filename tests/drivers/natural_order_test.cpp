// SPDX-License-Identifier: Apache-2.0
#include "drivers/recording/natural_order.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace srd {
namespace {

using Names = std::vector<std::string>;

struct Order {
  const char* name;
  Names right;
  bool note;  // another reading gives another order
};

void PrintTo(const Order& order, std::ostream* out) { *out << order.name; }

class NaturalOrder : public testing::TestWithParam<Order> {};

TEST_P(NaturalOrder, IsTheOneThatAPersonMeansHoweverTheFolderLists) {
  Names names = GetParam().right;
  std::mt19937 random(5);
  for (int turn = 0; turn < 20; ++turn) {
    std::shuffle(names.begin(), names.end(), random);
    const std::string note = sort_naturally(names);
    ASSERT_EQ(names, GetParam().right);
    EXPECT_EQ(!note.empty(), GetParam().note) << note;
    if (GetParam().note) {
      EXPECT_NE(note.find("first " + names.front() + ", last " + names.back()), std::string::npos) << note;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Names, NaturalOrder,
    testing::Values(
        Order{"counts", {"frame_1.PNG", "frame_02.png", "frame_2.png", "frame_10.png"}, false},
        Order{"long_counts", {"f_99999999999999999999999.png", "f_100000000000000000000000.png"}, false},
        Order{"bare_signs", {"-6.png", "-5.png", "-1.png", "0.png", "1.png", "5.png", "10.png"}, true},
        Order{"signs_with_plus", {"-10.png", "-2.png", "+0.png", "+3.png", "+12.png"}, true},
        Order{"signs_after_separator", {"t_-10.png", "t_-2.png", "t_3.png"}, true},
        Order{"signs_after_letters", {"z-6.png", "z-5.png", "z4.png", "z10.png"}, true},
        Order{"signs_after_dash", {"run-1.png", "run-2.png", "run-10.png"}, false},
        Order{"signs_beyond_dash", {"run--2.png", "run--1.png", "run-0.png", "run-3.png"}, true},
        Order{"signed_fractions", {"t_-1.png", "t_-0.5.png", "t_-0.25.png", "t_0.png", "t_0.25.png", "t_0.5.png"}, true},
        Order{"all_below_zero", {"-10.png", "-9.png", "-1.png"}, true},
        Order{"dashes_after_letters", {"img-1.png", "img-2.png", "img-5.png", "img-10.png"}, false},
        Order{"dates", {"2017-02-28.png", "2017-03-04.png", "2017-03-10.png", "2017-10-01.png"}, false},
        Order{"dotted_dates", {"2017.3.4.png", "2017.3.10.png", "2017.10.1.png"}, false},
        Order{"times_in_dates", {"2017-03-04_5-7.png", "2017-03-04_10-6.png"}, false},
        Order{"fractions", {"t_0.25.png", "t_0.5.png", "t_1.png", "t_1.125.png", "t_10.png"}, true},
        Order{"fractions_of_one_length", {"t_0.000.png", "t_0.040.png", "t_0.080.png", "t_0.100.png"}, false},
        Order{"fractions_with_leading_zeros", {"t0.05.png", "t0.10.png", "t0.5.png"}, true},
        Order{"fractions_with_point_zero", {"0.0.png", "0.25.png", "0.5.png", "1.0.png"}, true},
        Order{"counts_behind_a_point", {"cam1.8.png", "cam1.9.png", "cam1.10.png", "cam1.11.png"}, true},
        Order{"counts_of_one_length_behind_a_point", {"cam1.0008.png", "cam1.0010.png", "cam2.0001.png"}, false},
        Order{"letters_and_case", {"A.png", "a.png", "a1.png", "a1b.png", "b.png"}, false}),
    [](const auto& order) { return order.param.name; });

TEST(NaturalOrder, IsTheSameForEveryListOfTheSameNames) {
  std::mt19937 random(7);
  const std::string letters = "a01-+._9";
  for (int turn = 0; turn < 3000; ++turn) {
    Names names(6);
    for (std::string& name : names)
      for (std::size_t i = random() % 6 + 1; i > 0; --i) name += letters[random() % letters.size()];
    Names other = names;
    std::shuffle(other.begin(), other.end(), random);
    const std::string note = sort_naturally(names);
    EXPECT_EQ(sort_naturally(other), note);
    ASSERT_EQ(other, names);
  }
}

TEST(NaturalOrder, HoldsFewNames) {
  Names none, one{"-1.png"};
  EXPECT_EQ(sort_naturally(none), "");
  EXPECT_EQ(sort_naturally(one), "");
  EXPECT_EQ(one, Names{"-1.png"});
}

}  // namespace
}  // namespace srd
