// The only file that includes OpenImageIO.
#include "host/io/picture.hpp"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <vector>

namespace pxpl5::host::io {

namespace {

namespace fs = std::filesystem;

std::string suffix_of(const fs::path& path) {
    std::string suffix = path.extension().string();
    std::transform(suffix.begin(), suffix.end(), suffix.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return suffix;
}

void check(const fs::path& path, const Picture& picture) {
    const std::string file = path.string();
    constexpr std::array known = {".png", ".tif", ".tiff", ".exr"};
    if (std::find(known.begin(), known.end(), suffix_of(path)) == known.end()) {
        throw PictureError(fmt::format("{}: suffix is '{}', pictures are .png, .tif, .tiff or .exr",
                                       file, path.extension().string()));
    }
    if (picture.width < 1 || picture.height < 1 || picture.width > max_picture_side_px ||
        picture.height > max_picture_side_px) {
        throw PictureError(fmt::format("{}: picture of {}x{} pixels, each side must be 1 to {}",
                                       file, picture.width, picture.height, max_picture_side_px));
    }
    const std::size_t bytes =
        4 * static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height);
    if (picture.rgba.size() != bytes) {
        throw PictureError(fmt::format("{}: {}x{} pixels of RGBA need {} bytes, got {}", file,
                                       picture.width, picture.height, bytes, picture.rgba.size()));
    }
    const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
    if (!fs::is_directory(folder)) {
        throw PictureError(fmt::format("{}: its folder {} does not exist", file, folder.string()));
    }
}

bool is_opaque(const Picture& picture) {
    for (std::size_t index = 3; index < picture.rgba.size(); index += 4) {
        if (picture.rgba[index] != 255) {
            return false;
        }
    }
    return true;
}

void write_file(const fs::path& path, const Picture& picture) {
    const int channels = is_opaque(picture) ? 3 : 4;
    const bool is_exr = suffix_of(path) == ".exr";
    // OpenEXR has no 8-bit values; half holds each of the 256 apart.
    OIIO::ImageSpec spec(picture.width, picture.height, channels,
                         is_exr ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::UINT8);
    spec.attribute("ImageDescription", picture.description);
    spec.attribute("Software", "pxpl5");
    spec.attribute("oiio:ColorSpace", "sRGB");
    spec.attribute("oiio:UnassociatedAlpha", 1);
    spec.attribute("png:compressionLevel", 4);  // Half the time of 6 for 5 % more bytes.
    OIIO::attribute("threads", 1);
    const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(path.string());
    if (!output) {
        throw PictureError(fmt::format("{}: {}", path.string(), OIIO::geterror()));
    }
    const bool written = output->open(path.string(), spec) &&
                         output->write_image(OIIO::TypeDesc::UINT8, picture.rgba.data(), 4,
                                             OIIO::AutoStride, OIIO::AutoStride);
    // A PNG that the disk has no room for is told of by has_error() alone.
    if (!written || output->has_error() || !output->close() || output->has_error()) {
        throw PictureError(fmt::format("{}: {}", path.string(), output->geterror()));
    }
}

}  // namespace

void write_picture(const std::string& path, const Picture& picture) {
    const fs::path target(path);
    check(target, picture);
    // In the same folder, or the rename would not be atomic; same suffix, which says the format.
    const fs::path part =
        target.parent_path() /
        fmt::format(".{}.{}.part{}", target.stem().string(), getpid(), suffix_of(target));
    std::error_code failure;
    try {
        write_file(part, picture);
    } catch (const PictureError& error) {
        fs::remove(part, failure);
        throw PictureError(fmt::format("{}: cannot be written: {}", path, error.what()));
    }
    fs::rename(part, target, failure);
    if (failure) {
        const std::string reason = failure.message();
        fs::remove(part, failure);
        throw PictureError(fmt::format("{}: cannot be written: {}", path, reason));
    }
}

}  // namespace pxpl5::host::io
