// OME-Zarr images: the image's metadata, the description of one level, and its first chunks,
// through the whole import.
#include <limits>
#include <optional>
#include <vector>

#include "host/io/values/import_request.hpp"
#include "host/io/zarr/zarr_image.hpp"
#include "host/io/zarr/zarr_levels.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "tests/fuzz/imported.hpp"
#include "tests/fuzz/scratch.hpp"

namespace pxpl5::fuzz {

namespace {

namespace fs = std::filesystem;
using namespace host::io;

constexpr std::uint8_t next_file = 0x1e;  ///< Precedes the description and each chunk.

// Chunks without a file have the fill value, so that a small image can ask for any memory.
constexpr std::uint64_t most_values = std::uint64_t{1} << 18;
constexpr std::uint64_t most_chunk_bytes = std::uint64_t{1} << 20;

/// The image's level if the product reads the metadata, and if it is small.
std::optional<ZarrLevel> small_level(const fs::path& root) {
    try {
        const std::optional<ZarrImage> image = zarr_image_at(root);
        if (!image) {
            return std::nullopt;
        }
        ZarrLevel level = zarr_level_for(*image, root, {});
        std::uint64_t values = 1;
        for (const std::uint64_t size : level.array.shape) {
            values = size <= most_values ? values * size : most_values + 1;
            if (values > most_values) {
                return std::nullopt;
            }
        }
        return level.array.chunk_bytes() <= most_chunk_bytes ? std::optional(level) : std::nullopt;
    } catch (const ImportError& error) {
        require(std::string_view(error.what()).starts_with(root.string()),
                std::string("a refusal without the file: ") + error.what());
        return std::nullopt;
    }
}

}  // namespace

/// Input: the processing, .zattrs, 0/.zarray, and chunks side by side along the last axis.
bool accepts(Input input) {
    static const Scratch scratch;
    Bytes bytes(input);
    ImportRequest request;
    add_processing(bytes, request);
    scratch.clear();
    const fs::path root = scratch.path() / "v.zarr";
    fs::create_directories(root / "0");
    scratch.write("v.zarr/.zattrs", bytes.text_before(next_file));
    scratch.write("v.zarr/0/.zarray", bytes.text_before(next_file));
    const std::optional<ZarrLevel> level = small_level(root);
    if (!level) {
        return false;
    }
    std::vector<std::uint64_t> index(level->array.shape.size(), 0);
    for (; !bytes.empty(); ++index.back()) {
        const fs::path file = chunk_file(level->array, index);
        fs::create_directories(file.parent_path());
        scratch.write(file.lexically_relative(scratch.path()).string(),
                      bytes.text_before(next_file));
    }
    request.path = root.string();
    return imports(request);
}

}  // namespace pxpl5::fuzz
