// A head as tables, in mm: x to the left, y to the back, z to the crown. One half; the other is its
// mirror image, but for the folds of the brain.
#pragma once

#include "host/phantom/field.hpp"

namespace pxpl5::host::phantom::head {

// ---- skin ----
inline constexpr Ball skin_balls[] = {
    {{0, 10, 33}, {77, 94, 74}, {0, 0, 0}, 6},       // skull
    {{0, 40, -10}, {54, 56, 36}, {0, 0, 0}, 20},     // back of the head
    {{52, 20, -12}, {17, 34, 30}, {0, 0, 0}, 16},    // behind and below the ear
    {{0, -22, -30}, {57, 58, 56}, {0, 0, 0}, 22},    // face
    {{0, -30, -66}, {47, 46, 30}, {0, 0, 0}, 18},    // jaw
    {{0, -70, -86}, {17, 14, 13}, {0, 0, 0}, 14},    // chin
    {{34, -58, -36}, {20, 19, 24}, {0, 0, 0}, 16},   // cheek
    {{43, -56, -14}, {16, 15, 10}, {0, 0, 20}, 16},  // cheekbone
};
inline constexpr Rod neck = {{0, 28, -40}, 51, {0, 34, -150}, 50, 20};
inline constexpr Ball eye_sockets[] = {{{31, -90, 0}, {18, 14, 11}, {0, 0, -16}, 12}};
inline constexpr Ball eye_lids[] = {{{31, -64, 0}, {15, 14, 12}, {0, 0, -10}, 3}};
inline constexpr Rod features[] = {
    {{5, -81, 16}, 6, {22, -79, 19}, 6, 8},  // brow
    {{22, -79, 19}, 6, {46, -62, 14}, 4.5F, 8},
    {{0, -80, 10}, 6, {0, -88, -4}, 6, 9},        // bridge of the nose
    {{0, -86, -2}, 6, {0, -94, -25}, 7.5F, 6},    // back and tip of the nose
    {{8, -90, -28}, 6, {12, -84, -30}, 6, 4},     // wing of the nose
    {{0, -76, -46}, 12, {0, -74, -60}, 12, 10},   // the mouth's mound
    {{4, -87, -48}, 5, {22, -77, -52}, 3.5F, 3},  // upper lip
    {{0, -86, -59}, 6, {18, -77, -55}, 4, 3},     // lower lip
};
inline constexpr Rod creases[] = {
    {{0, -93, -53.5F}, 2, {24, -80, -53.5F}, 1.6F, 2},  // between the lips
    {{0, -91, -35}, 1.5F, {0, -93, -43}, 2, 4},         // groove above them
    {{6, -94, -35}, 3, {7, -84, -27}, 3, 2},            // nostril
    {{17, -76, -3}, 1.4F, {25, -80, -6}, 1.6F, 2},      // closed lids
    {{25, -80, -6}, 1.6F, {37, -79, -6}, 1.6F, 2},
    {{37, -79, -6}, 1.6F, {47, -70, -2}, 1.2F, 2},
    {{0, -90, -68}, 3, {10, -84, -68}, 2.5F, 7},  // above the chin
};
inline constexpr Corner ear_rim[] = {
    {{66, 6, -38}, 5},  {{70, 4, -24}, 3.5F}, {{73, 2, -8}, 3},
    {{75, 4, 6}, 3.5F}, {{79, 14, 17}, 4},    {{82, 27, 15}, 4},
    {{82, 32, 2}, 4},   {{77, 27, -15}, 4},   {{70, 15, -31}, 4.5F}};
inline constexpr Ball ear_shell = {{71, 17, -6}, {5, 14, 22}, {-10, 0, 18}, 5};
inline constexpr Ball ear_hollow = {{79, 9, -12}, {5, 7, 9}, {0, 0, 0}, 3};

// ---- air inside ----
inline constexpr Ball airways[] = {
    {{7, -46, -22}, {4, 34, 15}, {8, 0, 0}, 3},    // nose
    {{29, -48, -28}, {10, 13, 15}, {0, 0, 0}, 0},  // sinus of the cheek
    {{11, -68, 26}, {9, 5, 9}, {-20, 0, 0}, 0},    // sinus of the forehead
    {{0, -16, -22}, {9, 12, 9}, {0, 0, 0}, 4},     // throat behind the nose
};
inline constexpr Corner windpipe[] = {
    {{0, -8, -26}, 8}, {{0, -2, -60}, 8}, {{0, -8, -90}, 9}, {{0, -4, -130}, 9}};

// ---- bone of the face and neck, dark as all bone is ----
inline constexpr Corner jaw_bone[] = {{{0, -70, -82}, 7},
                                      {{22, -62, -82}, 7},
                                      {{42, -28, -76}, 6},
                                      {{48, -6, -62}, 6},
                                      {{50, -4, -30}, 5}};
inline constexpr Corner teeth[] = {{{0, -72, -54}, 6}, {{16, -66, -54}, 6}, {{26, -40, -54}, 6}};
inline constexpr Ball neck_bones[] = {{{0, 22, -48}, {16, 9, 7}, {0, 0, 0}, 0},
                                      {{0, 18, -67}, {14, 9, 8}, {0, 0, 0}, 0},
                                      {{0, 16, -87}, {14, 9, 8}, {0, 0, 0}, 0},
                                      {{0, 16, -107}, {15, 9, 8}, {0, 0, 0}, 0}};
inline constexpr Ball eye_ball = {{31, -63, 0}, {11.5F, 11.5F, 11.5F}, {0, 0, 0}, 0};

// ---- brain ----
/// The ellipsoid onto which the pattern of folds is drawn.
inline constexpr glm::vec3 brain_center(0, 12, 36), brain_radius(60, 78, 56);
inline constexpr Ball cerebrum[] = {
    {{26, 10, 40}, {32, 73, 47}, {0, 0, 0}, 10},  // hemisphere
    {{14, 10, 42}, {26, 70, 49}, {0, 0, 0}, 10},
    {{22, -34, 34}, {20, 28, 29}, {0, 0, 0}, 10},  // frontal lobe
    {{20, 60, 24}, {19, 22, 23}, {0, 0, 0}, 10},   // occipital lobe
    {{42, -2, 4}, {15, 39, 16}, {6, 0, 6}, 4},     // temporal lobe
};
/// The part that joins the hemispheres, without furrows.
inline constexpr Ball core = {{0, 12, 32}, {24, 42, 18}, {0, 0, 0}, 0};
/// Sylvian fissure, between the temporal lobe and the rest.
inline constexpr Corner lateral_fissure[] = {{{40, -34, 15}, 3},
                                             {{52, -18, 19}, 3},
                                             {{58, 6, 24}, 3},
                                             {{59, 28, 32}, 2.6F},
                                             {{55, 42, 40}, 2}};
inline constexpr Corner lateral_fissure_floor[] = {
    {{34, -28, 14}, 2.4F}, {{42, -8, 18}, 2.4F}, {{46, 12, 24}, 2}, {{46, 30, 30}, 1.6F}};
/// Central sulcus, between the lobes of moving and feeling.
inline constexpr Corner central_sulcus[] = {{{4, 26, 100}, 2.4F},
                                            {{24, 18, 94}, 2.4F},
                                            {{38, 14, 84}, 2.4F},
                                            {{52, 4, 66}, 2.4F},
                                            {{62, -4, 44}, 2.2F}};
inline constexpr Ball cerebellum[] = {{{21, 48, -12}, {27, 24, 18}, {10, 0, 0}, 6},
                                      {{0, 46, -10}, {10, 22, 16}, {0, 0, 0}, 4}};
inline constexpr Corner brain_stem[] = {{{0, 22, 14}, 14},
                                        {{0, 18, -4}, 14},
                                        {{0, 24, -24}, 11},
                                        {{0, 34, -46}, 7},
                                        {{0, 34, -130}, 6}};
/// Water in and around the brain: ventricles.
inline constexpr Corner ventricle[] = {{{7, -28, 40}, 4.5F},
                                       {{8, -8, 46}, 5},
                                       {{10, 14, 48}, 5},
                                       {{18, 34, 40}, 5.5F},
                                       {{22, 56, 34}, 3.5F}};
inline constexpr Corner ventricle_horn[] = {
    {{18, 34, 40}, 5}, {{28, 26, 20}, 3.5F}, {{30, 4, 8}, 3}};
inline constexpr Ball middle_ventricles[] = {{{0, 10, 28}, {2.8F, 12, 9}, {0, 0, 0}, 0},
                                             {{0, 42, -10}, {8, 5, 10}, {20, 0, 0}, 0}};

}  // namespace pxpl5::host::phantom::head
