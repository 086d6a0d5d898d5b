#include "host/inspect/map/picture_file.hpp"

#include <fmt/format.h>
#include <png.h>

#include <bit>
#include <cassert>
#include <string>
#include <string_view>

#include "host/base/error.hpp"
#include "host/base/part_file.hpp"

namespace pxpl5::host::inspect {

// Pixels are handed over as bytes red, green, blue, alpha.
static_assert(std::endian::native == std::endian::little);

void check_png_name(const std::filesystem::path& path) {
    if (path.extension() != ".png" && path.extension() != ".PNG") {
        throw RequestError(ExitCode::usage,
                           fmt::format("{}: this command writes only PNG files; use a name that "
                                       "ends in .png",
                                       path.string()));
    }
}

void write_png(const std::filesystem::path& path, int width, int height,
               std::span<const std::uint32_t> rgba) {
    check_png_name(path);
    assert(width > 0 && height > 0);
    assert(rgba.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = static_cast<png_uint_32>(width);
    image.height = static_cast<png_uint_32>(height);
    image.format = PNG_FORMAT_RGBA;
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
    std::string bytes(size, '\0');
    std::string failure;
    if (png_image_write_to_memory(&image, bytes.data(), &size, 0, rgba.data(), 0, nullptr) != 0) {
        remove_abandoned_parts(path);
        PartFile file(path);
        file.write(std::string_view(bytes).substr(0, size));
        failure = file.keep();
    } else {
        failure = image.message;
    }
    if (!failure.empty()) {
        throw RequestError(ExitCode::failed,
                           fmt::format("cannot write {}: {}", path.string(), failure));
    }
}

}  // namespace pxpl5::host::inspect
