#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

#include "host/io/values/processing.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::io;

namespace {

template <typename T>
constexpr Scalar scalar_of = std::is_same_v<T, float>          ? Scalar::float32
                             : std::is_same_v<T, std::int16_t> ? Scalar::int16
                                                               : Scalar::uint8;

/// A volume whose voxel (x, y, z) is f(x, y, z), 1 mm apart.
template <typename T, typename F>
Volume volume_of(int nx, int ny, int nz, F f) {
    Volume volume;
    volume.nx = nx;
    volume.ny = ny;
    volume.nz = nz;
    volume.type = scalar_of<T>;
    std::vector<T> values;
    for (int z = 0; z < nz; ++z) {
        for (int y = 0; y < ny; ++y) {
            for (int x = 0; x < nx; ++x) {
                values.push_back(static_cast<T>(f(x, y, z)));
            }
        }
    }
    volume.values.resize(values.size() * sizeof(T));
    std::memcpy(volume.values.data(), values.data(), volume.values.size());
    return volume;
}

template <typename T>
std::vector<T> values_of(const Volume& volume) {
    std::vector<T> values(volume.values.size() / sizeof(T));
    std::memcpy(values.data(), volume.values.data(), volume.values.size());
    return values;
}

template <typename T>
T at(const Volume& volume, int x, int y, int z) {
    return values_of<T>(volume)[static_cast<std::size_t>((z * volume.ny + y) * volume.nx + x)];
}

double linear(double x, double y, double z) {
    return 3 + 2 * x - 5 * y + 7 * z;
}

ImportRequest request_for() {
    ImportRequest request;
    request.path = "v";
    return request;
}

bool reports(const Volume& volume, const std::string& words) {
    return std::any_of(volume.findings.begin(), volume.findings.end(), [&](const Finding& f) {
        return f.kind == FindingKind::processed && f.text.find(words) != std::string::npos;
    });
}

}  // namespace

TEST_SUITE("host/io/processing") {
    TEST_CASE("a crop keeps its voxels where they are in the patient") {
        Volume volume = volume_of<std::int16_t>(
            6, 5, 4, [](int x, int y, int z) { return x + 10 * y + 100 * z; });
        volume.voxel_to_patient = {{2, 0, 0, 0}, {0, 0, 3, 0}, {0, 4, 0, 0}, {1, 1, 1, 1}};
        ImportRequest request = request_for();
        request.crop_first = {1, 2, 1};
        request.crop_size = {4, 3, 2};
        const glm::dvec4 old = volume.voxel_to_patient * glm::dvec4(3, 4, 2, 1);
        process_volume(request, volume);
        CHECK(std::array{volume.nx, volume.ny, volume.nz} == std::array{4, 3, 2});
        CHECK(at<std::int16_t>(volume, 2, 2, 1) == 3 + 40 + 200);
        CHECK(volume.voxel_to_patient * glm::dvec4(2, 2, 1, 1) == old);
        CHECK(volume.minimum == 1 + 20 + 100);
        CHECK(volume.maximum == 4 + 40 + 200);
        CHECK(reports(volume, "cropped to 4x3x2 voxels from voxel 1,2,1 of 6x5x4"));
    }

    TEST_CASE("a crop of uneven slices keeps their places and gaps") {
        Volume volume = volume_of<std::uint8_t>(2, 2, 5, [](int, int, int z) { return z; });
        volume.slice_places = {0, 1, 3, 4, 6};
        volume.gap_slabs = {1, 3};
        crop("v", {0, 0, 2}, {2, 2, 3}, volume);
        CHECK(volume.slice_places == std::vector<double>{0, 1, 3});
        CHECK(volume.gap_slabs == std::vector<int>{1});
        CHECK(volume.voxel_to_patient[3].z == 3);
    }

    TEST_CASE("what was said of missing slices is said of the file once slices are cropped away") {
        Volume whole = volume_of<std::uint8_t>(3, 3, 5, [](int, int, int z) { return z; });
        whole.slice_places = {0, 1, 3, 4, 6};
        whole.gap_slabs = {1, 3};
        whole.findings = {{FindingKind::missing_slices, "about 2 slices are missing"},
                          {FindingKind::note, "a note"}};
        const auto cropped = [&](std::uint32_t nx, std::uint32_t first_z, std::uint32_t nz) {
            Volume volume = whole;
            ImportRequest request = request_for();
            request.crop_first = {0, 0, first_z};
            request.crop_size = {nx, 3, nz};
            process_volume(request, volume);
            return volume;
        };
        const Volume late = cropped(3, 2, 2);
        CHECK(late.findings[0].text == "before cropping, about 2 slices are missing");
        CHECK(late.findings[1].text == "a note");
        CHECK(reports(late, "the crop leaves out 2 of 2 gaps of missing slices"));
        CHECK(reports(cropped(3, 2, 3), "the crop leaves out 1 of 2 gaps of missing slices"));
        const Volume narrow = cropped(2, 0, 5);
        CHECK(narrow.findings[0].text == "about 2 slices are missing");
        CHECK_FALSE(reports(narrow, "leaves out"));
    }

    TEST_CASE("a crop beyond the volume, or of half a wish, is refused with both values") {
        Volume volume = volume_of<std::uint8_t>(6, 5, 4, [](int, int, int) { return 1; });
        ImportRequest request = request_for();
        request.crop_first = {3, 0, 0};
        CHECK_THROWS_WITH_AS(process_volume(request, volume),
                             "v: a crop needs a first voxel and a size", ImportError);
        request.crop_size = {4, 5, 4};
        CHECK_THROWS_WITH_AS(process_volume(request, volume),
                             doctest::Contains("4 voxels from 3 on along x is asked for, it has 6"),
                             ImportError);
        request.crop_first = {4294967295U, 0, 0};
        CHECK_THROWS_AS(process_volume(request, volume), ImportError);
    }

    TEST_CASE("a linear density resampled is itself at every new voxel center") {
        Volume volume = volume_of<float>(7, 5, 4, linear);
        volume.voxel_to_patient = {{1.5, 0, 0, 0}, {0, 2, 0, 0}, {0, 0, 4, 0}, {9, 8, 7, 1}};
        const glm::dvec4 corner = volume.voxel_to_patient * glm::dvec4(6, 4, 3, 1);
        ImportRequest request = request_for();
        request.resample_size = {11, 3, 10};
        process_volume(request, volume);
        CHECK(std::array{volume.nx, volume.ny, volume.nz} == std::array{11, 3, 10});
        for (int z = 0; z < 10; ++z) {
            for (int x = 0; x < 11; ++x) {
                CHECK(at<float>(volume, x, 1, z) ==
                      doctest::Approx(linear(x * 0.6, 2, z / 3.0)).epsilon(1e-6));
            }
        }
        const glm::dvec4 moved = volume.voxel_to_patient * glm::dvec4(10, 2, 9, 1);
        CHECK(glm::length(moved - corner) < 1e-9);
        CHECK(reports(volume, "resampled from 7x5x4 to 11x3x10 voxels"));
    }

    TEST_CASE("resampled by spacing, voxels lie exactly so far apart, within the old extent") {
        Volume volume = volume_of<float>(7, 5, 4, linear);
        volume.voxel_to_patient[0] *= 0.5;
        ImportRequest request = request_for();
        request.resample_spacing_mm = glm::dvec3(1.25, 2, 1);
        process_volume(request, volume);
        // 3 mm hold voxels at 0, 1.25 and 2.5; 4 mm at 0, 2 and 4.
        CHECK(std::array{volume.nx, volume.ny, volume.nz} == std::array{3, 3, 4});
        CHECK(volume.voxel_to_patient[0].x == doctest::Approx(1.25));
        CHECK(at<float>(volume, 2, 2, 3) == doctest::Approx(linear(5, 4, 3)));
    }

    TEST_CASE("uneven slices resampled are even, and gaps stay gaps") {
        // Density is the place: 0, 1, 3, 4.
        Volume volume =
            volume_of<float>(2, 2, 4, [](int, int, int z) { return z < 2 ? z : z + 1; });
        volume.slice_places = {0, 1, 3, 4};
        volume.gap_slabs = {1};
        ImportRequest request = request_for();
        request.resample_size = {2, 2, 9};
        process_volume(request, volume);
        CHECK(volume.slice_places.empty());
        CHECK(volume.gap_slabs == std::vector<int>{2, 3, 4, 5});
        CHECK(volume.voxel_to_patient[2].z == 0.5);
        for (int z = 0; z < 9; ++z) {
            CHECK(at<float>(volume, 1, 0, z) == doctest::Approx(0.5 * z));
        }
        CHECK(reports(volume, "uneven slices have become even"));
    }

    TEST_CASE("whole types round to the nearest value, and sizes that make no sense are refused") {
        Volume volume =
            volume_of<std::int16_t>(2, 2, 2, [](int x, int, int) { return x * 10 - 5; });
        ImportRequest request = request_for();
        request.resample_size = {5, 2, 2};
        process_volume(request, volume);
        // -5, -2.5, 0, 2.5, 5: halves go up.
        CHECK(values_of<std::int16_t>(volume)[1] == -2);
        CHECK(values_of<std::int16_t>(volume)[3] == 3);
        request.resample_size = {5, 1, 2};
        CHECK_THROWS_WITH_AS(process_volume(request, volume),
                             doctest::Contains("1 voxels along y are asked for, must be 2 to 4096"),
                             ImportError);
        request.resample_spacing_mm = glm::dvec3(1);
        CHECK_THROWS_WITH_AS(process_volume(request, volume), doctest::Contains("give one of them"),
                             ImportError);
        request.resample_size.reset();
        request.resample_spacing_mm = glm::dvec3(1, -1, 1);
        CHECK_THROWS_AS(process_volume(request, volume), ImportError);
    }

    TEST_CASE("a point smoothed is a Gaussian of the width asked for, in millimeters") {
        constexpr int size = 41, middle = size / 2;
        Volume volume = volume_of<float>(size, size, size, [](int x, int y, int z) {
            return x == middle && y == middle && z == middle ? 1e6 : 0;
        });
        volume.voxel_to_patient[0] *= 0.5;
        volume.voxel_to_patient[2] *= 0.75;
        smooth(1.5, volume);
        const std::vector<float> values = values_of<float>(volume);
        const double sum = std::accumulate(values.begin(), values.end(), 0.0);
        CHECK(sum == doctest::Approx(1e6).epsilon(1e-4));
        const double peak = at<float>(volume, middle, middle, middle);
        for (const int steps : {1, 2, 4}) {
            const double mm[] = {0.5 * steps, 1.0 * steps, 0.75 * steps};
            const float got[] = {at<float>(volume, middle + steps, middle, middle),
                                 at<float>(volume, middle, middle - steps, middle),
                                 at<float>(volume, middle, middle, middle + steps)};
            for (int axis = 0; axis < 3; ++axis) {
                const double ratio = std::exp(-0.5 * mm[axis] * mm[axis] / (1.5 * 1.5));
                CHECK(got[axis] / peak == doctest::Approx(ratio).epsilon(1e-5));
            }
        }
    }

    TEST_CASE("a constant smoothed is itself, at borders, across gaps and beside NaN") {
        Volume volume = volume_of<float>(5, 4, 6, [](int x, int y, int z) {
            return x == 2 && y == 2 && z == 2 ? std::nan("") : 7.5;
        });
        volume.slice_places = {0, 1, 2, 5, 6, 7.5};
        ImportRequest request = request_for();
        request.smooth_mm = 1.2;
        process_volume(request, volume);
        int not_a_number = 0;
        for (const float value : values_of<float>(volume)) {
            not_a_number += std::isnan(value) ? 1 : 0;
            CHECK((std::isnan(value) || std::abs(value - 7.5F) < 1e-5F));
        }
        CHECK(not_a_number == 1);
        CHECK(reports(volume, "smoothed by a Gaussian of 1.2 mm"));
        request.smooth_mm = -1;
        CHECK_THROWS_WITH_AS(process_volume(request, volume), doctest::Contains("by -1 mm"),
                             ImportError);
    }

    TEST_CASE("slices far apart are smoothed less into each other: distance counts, not number") {
        Volume volume = volume_of<float>(2, 2, 3, [](int, int, int z) { return z == 1 ? 100 : 0; });
        volume.slice_places = {0, 1, 3};
        smooth(1.0, volume);
        const double near = std::exp(-0.5), far = std::exp(-2.0);
        CHECK(at<float>(volume, 0, 0, 1) == doctest::Approx(100 / (1 + near + far)));
        CHECK(at<float>(volume, 0, 0, 0) ==
              doctest::Approx(100 * near / (1 + near + std::exp(-4.5))));
    }
}
