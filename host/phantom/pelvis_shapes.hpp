// The pelvis as tables, in mm: x to the left, y to the back, z to the head, 0 midway between the
// hip joints. Only the left half is written; the right one is its mirror image.
#pragma once

#include "host/phantom/field.hpp"

namespace pxpl5::host::phantom::pelvis {

// The hip joint.
inline constexpr glm::vec3 hip_center_mm(86, 0, 0);
inline constexpr float femur_head_radius_mm = 23.5F, socket_radius_mm = 28, cup_radius_mm = 34.5F;

// ---- hip bone: corners of plates, with half the thickness ----
inline constexpr Corner hip_corners[] = {
    // Iliac crest, front to back.
    {{120, -48, 80}, 6},   //  0 anterior superior spine
    {{131, -36, 102}, 5},  //  1
    {{139, -16, 117}, 6},  //  2 tubercle
    {{134, 12, 127}, 5},   //  3
    {{116, 40, 127}, 5},   //  4
    {{88, 66, 110}, 6},    //  5
    {{64, 82, 92}, 7},     //  6
    {{46, 88, 72}, 8},     //  7 posterior superior spine
    // Lower edge of the wing, front to back.
    {{112, -38, 58}, 5},  //  8 between the anterior spines
    {{106, -38, 40}, 7},  //  9 anterior inferior spine
    {{108, -10, 32}, 8},  // 10 roof of the socket
    {{98, 20, 30}, 8},    // 11
    {{76, 42, 34}, 7},    // 12
    {{60, 58, 40}, 6},    // 13 top of the greater notch
    {{46, 78, 50}, 7},    // 14 posterior inferior spine
    // The wing's hollow.
    {{121, -22, 74}, 3.2F},  // 15
    {{120, 6, 80}, 3},       // 16
    {{104, 32, 82}, 3.2F},   // 17
    {{76, 56, 74}, 6},       // 18
    // Arcuate line and inner wall.
    {{66, 40, 42}, 6},   // 19
    {{66, 12, 20}, 6},   // 20
    {{72, -24, 14}, 7},  // 21 iliopubic eminence
    {{64, 20, -6}, 5},   // 22
    {{64, -4, -14}, 5},  // 23
    // Back column and ischium.
    {{78, 38, 12}, 8},      // 24
    {{58, 46, -12}, 4.5F},  // 25 ischial spine
    {{70, 34, -22}, 9},     // 26
    {{66, 34, -48}, 11},    // 27
    {{60, 26, -68}, 11},    // 28 tuberosity
    {{76, 14, -32}, 9},     // 29
    // Pubis.
    {{50, -38, 4}, 6.5F},    // 30 upper ramus
    {{28, -46, -8}, 6.5F},   // 31 tubercle
    {{11, -45, -14}, 8},     // 32 symphysis, top
    {{10, -38, -38}, 7.5F},  // 33 symphysis, bottom
    {{24, -40, -30}, 6},     // 34
    {{36, -18, -56}, 6},     // 35 lower ramus
    {{50, 4, -70}, 7},       // 36
};
inline constexpr Plate hip_plates[] = {
    {0, 1, 15},   {0, 8, 15},   {1, 2, 15},   {2, 16, 15},  {2, 3, 16},   {3, 4, 16},
    {4, 17, 16},  {4, 5, 17},   {5, 18, 17},  {5, 6, 18},   {6, 7, 18},   {7, 14, 18},
    {14, 13, 18}, {13, 19, 18}, {8, 9, 15},   {9, 10, 15},  {10, 16, 15}, {10, 11, 16},
    {11, 17, 16}, {11, 12, 17}, {12, 18, 17}, {12, 19, 18}, {12, 13, 19}, {9, 21, 10},
    {10, 21, 20}, {10, 20, 11}, {11, 20, 19}, {11, 19, 12}, {19, 24, 12}, {19, 20, 24},
    {20, 22, 24}, {24, 22, 25}, {24, 25, 26}, {22, 25, 26}, {22, 26, 29}, {20, 21, 23},
    {20, 23, 22}, {22, 23, 29}, {26, 27, 29}, {27, 28, 29}, {28, 36, 27}, {9, 30, 21},
    {31, 32, 34}, {32, 33, 34}, {30, 31, 34},
};
inline constexpr Rod hip_rods[] = {
    {{72, -24, 14}, 8, {50, -38, 4}, 6.5F, 5}, {{50, -38, 4}, 6.5F, {28, -46, -8}, 7, 5},
    {{24, -40, -34}, 6, {36, -20, -56}, 6, 4}, {{36, -20, -56}, 6, {50, 4, -70}, 7, 5},
    {{50, 4, -70}, 7, {60, 24, -70}, 10, 5},   {{70, 34, -22}, 9, {58, 48, -14}, 4, 4},
};

/// Cartilage between the pubic bones.
inline constexpr Ball symphysis = {{0, -42, -26}, {3.8F, 20, 30}, {0, 0, 0}, 2};

// ---- femur ----
inline constexpr Rod femur_rods[] = {
    {{90, 0, -3}, 17, {122, 6, -28}, 16, 6},    // neck
    {{122, 6, -30}, 17, {127, 6, -52}, 17, 8},  // between the trochanters
    {{127, 6, -48}, 17, {120, 2, -110}, 14.5F, 8},
    {{132, 12, -20}, 12, {131, 10, -40}, 15, 8},  // greater trochanter
    {{130, 20, -14}, 8, {134, 14, -26}, 12, 6},
    {{104, 22, -58}, 6, {117, 12, -58}, 11, 6},  // lesser trochanter
};
inline constexpr Rod femur_marrow = {{125, 5, -62}, 8, {120, 2, -110}, 9.5F, 4};

// ---- sacrum and coccyx ----
inline constexpr Ball sacrum_bodies[] = {
    {{0, 38, 84}, {26, 18, 15}, {28, 0, 0}, 6},   {{0, 58, 60}, {21, 13, 15}, {35, 0, 0}, 7},
    {{0, 73, 37}, {17, 10, 13}, {22, 0, 0}, 7},   {{0, 80, 16}, {14, 8, 12}, {4, 0, 0}, 7},
    {{0, 79, -3}, {11, 7, 11}, {-16, 0, 0}, 7},   {{0, 71, -20}, {9, 5, 8}, {-32, 0, 0}, 4},
    {{0, 62, -32}, {6, 4.5F, 7}, {-42, 0, 0}, 4}, {{0, 53, -42}, {4, 4, 5}, {-50, 0, 0}, 4},
};
inline constexpr Corner sacrum_corners[] = {
    {{10, 40, 88}, 11},  // 0
    {{50, 48, 84}, 9},   // 1 wing
    {{52, 62, 70}, 9},   // 2
    {{48, 72, 48}, 8},   // 3
    {{12, 62, 58}, 10},  // 4
    {{36, 80, 26}, 7},   // 5
    {{10, 76, 34}, 9},   // 6
    {{28, 84, 6}, 6},    // 7
    {{8, 82, 10}, 8},    // 8
    {{16, 80, -10}, 5},  // 9
    {{22, 60, 84}, 7},   // 10 upper joint of the back
    {{26, 84, 52}, 6},   // 11
    {{18, 92, 26}, 5},   // 12
};
inline constexpr Plate sacrum_plates[] = {
    {0, 1, 2}, {0, 2, 4}, {2, 3, 4},   {3, 5, 4},  {4, 5, 6},  {5, 7, 6},
    {6, 7, 8}, {7, 9, 8}, {10, 2, 11}, {2, 3, 11}, {3, 5, 12}, {3, 11, 12},
};
inline constexpr Corner sacrum_crest[] = {
    {{0, 78, 86}, 4}, {{0, 92, 66}, 5}, {{0, 100, 46}, 5}, {{0, 101, 24}, 4.5F}, {{0, 96, 6}, 4}};
inline constexpr Rod sacrum_laminae[] = {{{22, 62, 82}, 5, {0, 80, 80}, 5, 4},
                                         {{24, 78, 60}, 5, {0, 94, 58}, 5, 4},
                                         {{20, 88, 40}, 5, {0, 99, 38}, 5, 4},
                                         {{17, 92, 20}, 5, {0, 99, 18}, 4, 4}};
/// Holes for the nerves, carved from front to back.
inline constexpr Rod sacrum_holes[] = {{{27, 36, 64}, 6, {25, 100, 88}, 5, 3},
                                       {{23, 50, 36}, 5.5F, {21, 112, 58}, 4.5F, 3},
                                       {{19, 60, 20}, 5, {18, 116, 32}, 4, 3},
                                       {{16, 62, 4}, 4.5F, {15, 116, 6}, 3.5F, 3}};
inline constexpr Corner sacrum_canal[] = {
    {{0, 56, 110}, 9}, {{0, 64, 84}, 9}, {{0, 80, 56}, 7}, {{0, 90, 32}, 5}, {{0, 91, 10}, 4}};

// ---- fifth lumbar vertebra ----
inline constexpr Ball lumbar_body = {{0, 16, 112}, {26, 19, 14}, {14, 0, 0}, 0};
inline constexpr Rod lumbar_arches[] = {{{17, 26, 118}, 7, {20, 48, 116}, 7, 4},
                                        {{20, 48, 118}, 7, {2, 66, 110}, 5, 5},
                                        {{20, 34, 118}, 6, {48, 40, 122}, 4.5F, 5},
                                        {{20, 48, 124}, 6, {21, 58, 100}, 6, 5}};
inline constexpr Rod lumbar_spine = {{0, 66, 112}, 5, {0, 88, 104}, 5.5F, 5};

// ---- the body's outline ----
inline constexpr Ball body_balls[] = {
    {{0, 8, 150}, {157, 97, 150}, {0, 0, 0}, 30},   // waist
    {{0, 20, 24}, {162, 98, 86}, {0, 0, 0}, 40},    // hips
    {{0, -34, 78}, {104, 62, 70}, {0, 0, 0}, 30},   // belly
    {{62, 66, -24}, {70, 56, 70}, {0, 0, 10}, 22},  // buttocks
    {{0, -54, -22}, {36, 26, 40}, {0, 0, 0}, 36},   // mound over the symphysis
    {{106, -40, 84}, {34, 34, 34}, {0, 0, 0}, 40},  // over the front spine of the ilium
};
inline constexpr Rod body_rods[] = {{{88, 4, -14}, 76, {85, -4, -200}, 66, 22}};  // thigh
/// Where the navel is.
inline constexpr Ball navel = {{0, -108, 104}, {8, 12, 10}, {0, 0, 0}, 10};
/// Hollows: carved, each also on the other side.
inline constexpr Rod body_hollows[] = {
    {{124, -104, 62}, 12, {52, -112, -34}, 14, 26},  // groin
    {{0, 154, 4}, 4, {0, 112, -120}, 14, 22},        // between the buttocks
    {{0, 125, 136}, 8, {0, 142, 40}, 4, 22},         // over the spine
};

// ---- muscles ----
inline constexpr Ball muscle_balls[] = {
    {{128, 40, 66}, {24, 52, 60}, {-8, 10, 24}},  // gluteus medius
    {{128, 8, 50}, {20, 38, 52}, {0, 14, 6}},     // gluteus minimus
    {{110, -12, 88}, {12, 42, 38}, {0, 8, -14}},  // iliacus
    {{66, 48, -6}, {42, 14, 16}, {0, 0, -12}},    // piriformis and its neighbors
    {{48, -4, -34}, {13, 38, 30}, {0, 0, -20}},   // obturator
};
inline constexpr Rod muscle_rods[] = {
    {{26, 76, 160}, 26, {24, 94, 60}, 16},
    {{62, 70, 160}, 26, {54, 84, 104}, 14},   // back
    {{84, 32, -36}, 11, {124, 18, -46}, 11},  // quadratus femoris
};
/// Bundles of gluteus maximus, which no fat parts.
inline constexpr Strand gluteus_maximus[] = {
    {{{56, 86, 74}, 13}, {{104, 70, 30}, 24}, {{140, 28, -30}, 10}},
    {{{36, 92, 44}, 14}, {{80, 86, 2}, 30}, {{136, 34, -48}, 12}},
    {{{18, 92, 8}, 11}, {{54, 84, -30}, 29}, {{122, 40, -80}, 16}},
};
inline constexpr float bundle_blend_mm = 8;
inline constexpr Strand muscle_strands[] = {
    {{{44, 10, 150}, 25}, {{64, -20, 56}, 21}, {{104, -4, -50}, 11}},      // psoas
    {{{124, -40, 76}, 8}, {{146, -30, 24}, 17}, {{152, -12, -70}, 8}},     // tensor fasciae latae
    {{{106, -40, 46}, 8}, {{108, -54, -16}, 20}, {{106, -54, -120}, 25}},  // rectus femoris
    {{{138, 4, -22}, 13}, {{132, -8, -66}, 34}, {{122, -14, -130}, 42}},   // vasti
    {{{116, -48, 72}, 7}, {{88, -62, -6}, 11}, {{52, -52, -110}, 14}},     // sartorius
    {{{50, -44, 4}, 10}, {{80, -30, -26}, 15}, {{108, -8, -60}, 8}},       // pectineus
    {{{28, -44, -12}, 8}, {{54, -42, -58}, 18}, {{84, -32, -130}, 24}},    // adductor longus
    {{{20, -30, -44}, 8}, {{30, -8, -76}, 14}, {{40, 4, -140}, 15}},       // gracilis
    {{{46, 0, -60}, 15}, {{62, 10, -92}, 30}, {{74, 14, -140}, 34}},       // adductor magnus
    {{{64, 36, -62}, 13}, {{82, 54, -92}, 34}, {{90, 54, -140}, 36}},      // hamstrings
};

/// The middle of the belly's wall, and half its thickness.
inline constexpr Ball belly_wall = {{0, 2, 130}, {138, 75, 172}};
inline constexpr float belly_wall_half_mm = 7;
/// Where the wall ends: the ligament of the groin from spine to tubercle, then the iliac crest.
inline constexpr glm::vec3 groin_outer_mm(122, -48, 82), groin_inner_mm(24, -46, -10);
inline constexpr float crest_rise = 0.75F;  ///< Rise of the crest towards the back.
inline constexpr float wall_back_mm = 54;
/// The straight muscle of the belly, between the white line and its outer edge.
inline constexpr float white_line_half_mm = 1.5F;
inline constexpr float rectus_half_width_mm = 46, rectus_narrows_from_mm = 100;
inline constexpr float rectus_narrowing = 0.26F;                    ///< Per mm downwards.
inline constexpr float tendon_height_mm = 104, tendon_half_mm = 9;  ///< Thinner here.
inline constexpr float tendon_depth_mm = 2.5F;
inline constexpr float wall_edge_mm = 5;  ///< Rounds the edges of the wall.

/// Cartilage, ligaments and nerves, which fill the gaps and canals of bone.
inline constexpr Rod cartilage[] = {
    {{0, -44, -12}, 8, {0, -38, -38}, 8}, {{0, 26, 100}, 22, {0, 20, 136}, 22},
    {{50, 50, 80}, 9, {46, 72, 50}, 9},   {{0, 50, 130}, 11, {0, 64, 84}, 11},
    {{0, 64, 84}, 11, {0, 80, 56}, 9},    {{0, 80, 56}, 9, {0, 90, 32}, 7},
    {{0, 90, 32}, 7, {0, 91, 4}, 6},      {{26, 46, 68}, 8, {25, 88, 80}, 8},
    {{22, 58, 40}, 8, {21, 96, 52}, 7},   {{19, 68, 22}, 7, {18, 102, 28}, 6},
    {{16, 70, 4}, 6, {15, 102, 6}, 5},    {{22, 54, 112}, 12, {12, 72, 110}, 11},
};

// ---- what lies inside ----
inline constexpr Ball bladder = {{0, -22, 8}, {34, 24, 22}, {20, 0, 0}, 0};
inline constexpr Ball womb = {{0, 14, 26}, {22, 16, 30}, {-50, 0, 0}, 8};
inline constexpr Corner rectum[] = {{{0, 44, -60}, 10},  {{0, 50, -30}, 16},  {{0, 60, 10}, 17},
                                    {{6, 48, 46}, 15},   {{34, 20, 50}, 14},  {{56, 10, 74}, 14},
                                    {{40, -18, 78}, 14}, {{70, -30, 92}, 15}, {{96, -20, 110}, 16},
                                    {{104, 10, 150}, 17}};
inline constexpr Corner blind_gut[] = {{{-90, -22, 74}, 19}, {{-94, -10, 160}, 22}};
/// The bulk of the bowel, too close together for fat to show between.
inline constexpr Ball bowel_bulk[] = {{{0, -16, 124}, {112, 54, 46}, {0, 0, 0}, 12},
                                      {{0, -30, 70}, {84, 38, 44}, {-10, 0, 0}, 12}};
/// Gas in the bowel, which only this side of the patient has.
inline constexpr Ball gas[] = {{{70, -40, 98}, {10, 10, 10}}, {{3, 60, 8}, {8, 7, 13}}};

}  // namespace pxpl5::host::phantom::pelvis
