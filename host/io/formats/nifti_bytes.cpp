#include "host/io/formats/nifti_bytes.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host/io/formats/header_bytes.hpp"
#include "host/io/values/header_text.hpp"
#include "host/io/values/import_request.hpp"

namespace pxpl5::host::io {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t nifti1_bytes = 348, nifti2_bytes = 540;

void take_nifti1(const HeaderBytes& raw, NiftiFields& fields) {
    raw.copy<std::int16_t>(40, fields.dim);
    fields.datatype = raw.at<std::int16_t>(70);
    fields.bitpix = raw.at<std::int16_t>(72);
    raw.copy<float>(76, fields.pixdim);
    fields.vox_offset = static_cast<double>(raw.at<float>(108));
    fields.scl_slope = static_cast<double>(raw.at<float>(112));
    fields.scl_inter = static_cast<double>(raw.at<float>(116));
    fields.xyzt_units = raw.at<std::uint8_t>(123);
    fields.qform_code = raw.at<std::int16_t>(252);
    fields.sform_code = raw.at<std::int16_t>(254);
    raw.copy<float>(256, fields.quatern);
    raw.copy<float>(268, fields.qoffset);
    for (std::size_t row = 0; row < 3; ++row) {
        raw.copy<float>(280 + 16 * row, fields.srow[row]);
    }
}

void take_nifti2(const HeaderBytes& raw, NiftiFields& fields) {
    raw.copy<std::int64_t>(16, fields.dim);
    fields.datatype = raw.at<std::int16_t>(12);
    fields.bitpix = raw.at<std::int16_t>(14);
    raw.copy<double>(104, fields.pixdim);
    fields.vox_offset = static_cast<double>(raw.at<std::int64_t>(168));
    fields.scl_slope = raw.at<double>(176);
    fields.scl_inter = raw.at<double>(184);
    fields.xyzt_units = raw.at<std::int32_t>(500);
    fields.qform_code = raw.at<std::int32_t>(344);
    fields.sform_code = raw.at<std::int32_t>(348);
    raw.copy<double>(352, fields.quatern);
    raw.copy<double>(376, fields.qoffset);
    for (std::size_t row = 0; row < 3; ++row) {
        raw.copy<double>(400 + 32 * row, fields.srow[row]);
    }
}

/// "x.hdr.gz" with `from` .hdr and `to` .img -> "x.img.gz", or "x.img" if only that is there.
fs::path partner(const fs::path& path, const std::string& from, std::string to) {
    std::string name = path.string();
    const std::size_t at = lower_case(name).rfind(from);
    const bool is_suffix = at != std::string::npos &&
                           (at + 4 == name.size() || lower_case(name.substr(at + 4)) == ".gz");
    if (!is_suffix) {
        return path;
    }
    if (name[at + 1] == static_cast<char>(from[1] - 'a' + 'A')) {
        std::transform(to.begin(), to.end(), to.begin(),
                       [](char c) { return c == '.' ? c : static_cast<char>(c - 'a' + 'A'); });
    }
    name.replace(at, 4, to);
    const bool has_gz = name.size() > at + 4;
    const std::string other = has_gz ? name.substr(0, at + 4) : name + ".gz";
    return !fs::exists(name) && fs::exists(other) ? other : name;
}

}  // namespace

NiftiFields read_nifti_fields(const fs::path& path) {
    const std::string file = path.string();
    HeaderBytes raw = read_header_bytes(path, nifti1_bytes, nifti2_bytes);
    const auto little = raw.at<std::int32_t>(0);
    raw.big_endian = little != nifti1_bytes && little != nifti2_bytes;
    const auto size = static_cast<std::size_t>(std::max(raw.at<std::int32_t>(0), 0));
    if (size != nifti1_bytes && size != nifti2_bytes) {
        throw ImportError(fmt::format(
            "{}: sizeof_hdr is {}, must be {} (NIfTI-1, Analyze) or {} (NIfTI-2) in one of the "
            "byte orders",
            file, little, nifti1_bytes, nifti2_bytes));
    }
    check_header_size(file, raw, size);
    NiftiFields fields;
    fields.big_endian = raw.big_endian;
    const bool is_second = size == nifti2_bytes;
    fields.magic = is_second ? raw.text(4, 4) : raw.text(344, 4);
    const std::string end = is_second ? "2" : "1";
    fields.single = fields.magic == "n+" + end;
    const bool pair = fields.magic == "ni" + end;
    if (is_second && !fields.single && !pair) {
        throw ImportError(
            fmt::format("{}: magic is '{}', must be 'n+2' or 'ni2'", file, shown(fields.magic)));
    }
    fields.version = is_second ? 2 : fields.single || pair ? 1 : 0;
    is_second ? take_nifti2(raw, fields) : take_nifti1(raw, fields);
    return fields;
}

fs::path nifti_header_file(const fs::path& path) {
    return partner(path, ".img", ".hdr");
}

fs::path nifti_image_file(const fs::path& path) {
    return partner(nifti_header_file(path), ".hdr", ".img");
}

}  // namespace pxpl5::host::io
