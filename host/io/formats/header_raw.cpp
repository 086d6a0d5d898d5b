// A file without a header, with the user's description.
#include <fmt/format.h>

#include <limits>

#include "host/io/formats/stored_header.hpp"
#include "host/io/values/header_text.hpp"

namespace pxpl5::host::io {

StoredHeader read_raw_layout(const std::filesystem::path& path, const RawLayout& layout) {
    const std::string file = path.string();
    StoredHeader header;
    const std::optional<Component> component = component_named(layout.type);
    if (!component || layout.type != component_name(*component)) {
        throw ImportError(fmt::format(
            "{}: type '{}' must be uint8, int8, uint16, int16, uint32, int32, uint64, int64, "
            "float32 or float64",
            file, shown(layout.type)));
    }
    header.component = *component;
    header.type = layout.type;
    header.sizes.assign(layout.dims.begin(), layout.dims.end());
    header.big_endian = layout.big_endian;
    header.data_files = {path};
    header.byte_skip = layout.offset_bytes;
    header.spacing_stated.fill(false);
    volume_dims(file, header.sizes);
    header.assumed_directions =
        "a raw file states no patient space: x, y, z are taken as left, posterior, superior";
    if (lower_case(path.extension().string()) == ".gz" && is_gzip(path)) {
        header.encoding = Encoding::gzip;
        header.fits_exactly = true;
        check_stored_header(path, header);
        return header;
    }
    const std::uint64_t needed = needed_bytes(header);
    const std::uint64_t has = std::filesystem::file_size(path);
    // Another size means another type, other dims or a header: each turns the picture to noise.
    if (layout.offset_bytes > has || has - layout.offset_bytes != needed) {
        throw ImportError(
            fmt::format("{}: {} of {} after {} bytes need a file of {} bytes, it has {}", file,
                        join_sizes(header.sizes), header.type, layout.offset_bytes,
                        needed + layout.offset_bytes, has));
    }
    check_stored_header(path, header);
    return header;
}

}  // namespace pxpl5::host::io
