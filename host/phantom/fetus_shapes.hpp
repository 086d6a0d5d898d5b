// A fetal face as tables, in mm: x to the fetus's left, y to its back, z to its crown.
#pragma once

#include "host/phantom/field.hpp"

namespace pxpl5::host::phantom::fetus {

/// The head, one half; the other is its mirror image.
inline constexpr Ball head_balls[] = {
    {{0, 17, 12}, {31, 30, 22}, {0, 0, 0}, 6},         // skull
    {{0, 9, 15}, {25, 23.5F, 16}, {0, 0, 0}, 8},       // forehead
    {{0, 11, -8}, {25, 21, 20}, {0, 0, 0}, 9},         // face
    {{14, -2.5F, -11}, {11, 10, 10}, {0, 0, 0}, 7},    // cheek
    {{0, -6.5F, -23.5F}, {7.5F, 6, 5}, {0, 0, 0}, 5},  // chin
    {{0, 6, -25}, {15, 13, 7.5F}, {0, 0, 0}, 7},       // under the jaw
};
inline constexpr Ball eye_sockets[] = {{{11, -16.5F, 3}, {7.5F, 5, 4.5F}, {0, 0, -14}, 6}};
inline constexpr Ball eye_lids[] = {{{11, -7, 2.2F}, {6.6F, 5.4F, 4.8F}, {0, 0, -10}, 1.5F}};
inline constexpr Rod features[] = {
    {{0, -11, 5}, 3.2F, {0, -13.4F, -1}, 2.6F, 5},                  // bridge of the nose
    {{0, -13, 0}, 2.6F, {0, -16.4F, -5.4F}, 3.2F, 4},               // back and tip of the nose
    {{3.8F, -13.6F, -6.2F}, 2.5F, {4.8F, -12, -6.6F}, 2.4F, 1.5F},  // wing of the nose
    {{4, -13, 8.5F}, 1.8F, {10, -12, 9.6F}, 2, 5},                  // brow
    {{10, -12, 9.6F}, 2, {18, -6.5F, 8}, 1.6F, 5},
    {{0, -10.5F, -13}, 5, {0, -10.5F, -18.5F}, 5, 5},                 // the mouth's mound
    {{1.8F, -15.8F, -13.5F}, 2.4F, {6.8F, -12.4F, -15.3F}, 1.6F, 1},  // upper lip
    {{0, -15.4F, -18.9F}, 2.8F, {5.8F, -12.4F, -17.2F}, 1.7F, 1},     // lower lip
};
inline constexpr Rod creases[] = {
    {{0, -18, -16.2F}, 1, {7.8F, -14, -16.2F}, 0.8F, 1},          // between the lips
    {{0, -17.6F, -9.8F}, 0.6F, {0, -18.6F, -12.4F}, 0.9F, 1.5F},  // groove above them
    {{2, -17, -9}, 1, {2.1F, -14, -7.4F}, 0.9F, 0.8F},            // nostril
    {{5, -12.6F, 1}, 0.6F, {8.5F, -13.2F, -0.6F}, 0.8F, 0.8F},    // closed lids
    {{8.5F, -13.2F, -0.6F}, 0.8F, {13.5F, -12.9F, -0.6F}, 0.8F, 0.8F},
    {{13.5F, -12.9F, -0.6F}, 0.8F, {17.4F, -9.6F, 1}, 0.6F, 0.8F},
};
inline constexpr Corner ear_rim[] = {
    {{26, 10, -9}, 2.4F}, {{28, 13, -4}, 1.8F}, {{29.5F, 9, 4}, 1.8F}, {{30.5F, 12, 9}, 2},
    {{31.5F, 17, 8}, 2},  {{31, 19, 2}, 2},     {{28.5F, 15, -6}, 2}};
inline constexpr Ball ear_shell = {{29, 14, 2}, {1.8F, 5, 8}, {-12, 0, 10}, 2};

/// Neck and shoulders.
inline constexpr Ball trunk_balls[] = {{{0, 17, -34}, {15, 13, 12}, {0, 0, 0}, 6},
                                       {{0, 20, -48}, {40, 16, 14}, {0, 0, 0}, 8}};

/// The left hand beside the cheek, half closed; the other is out of the picture.
inline constexpr Rod arm[] = {{{37, 4, -44}, 7.5F, {29, -3, -29}, 5.5F, 3}};
inline constexpr Ball palm = {{26.5F, -6, -22}, {4.2F, 6.2F, 6.4F}, {0, 18, 14}, 3};
inline constexpr Rod fingers[] = {
    {{26, -11, -18.5F}, 2.1F, {23.5F, -13.5F, -12.5F}, 2, 0.8F},
    {{23.5F, -13.5F, -12.5F}, 2, {20.5F, -12.5F, -9.5F}, 1.8F, 0.8F},
    {{27.5F, -8, -16.5F}, 2.2F, {26.3F, -11, -9.5F}, 2, 0.8F},
    {{26.3F, -11, -9.5F}, 2, {23.8F, -11, -5.6F}, 1.8F, 0.8F},
    {{28.5F, -4.5F, -16}, 2.1F, {28.6F, -7, -8.5F}, 1.9F, 0.8F},
    {{28.6F, -7, -8.5F}, 1.9F, {27, -8, -3.6F}, 1.7F, 0.8F},
    {{29, -1, -17}, 1.9F, {30.6F, -2.5F, -10.5F}, 1.7F, 0.8F},
    {{30.6F, -2.5F, -10.5F}, 1.7F, {30.4F, -4, -6}, 1.5F, 0.8F},
    {{25, -10, -25}, 2.4F, {20.5F, -13.5F, -21.5F}, 2.1F, 1},
    {{20.5F, -13.5F, -21.5F}, 2.1F, {18.5F, -14, -18}, 1.9F, 1},
};

}  // namespace pxpl5::host::phantom::fetus
