#include "host/io/formats/picture_stack.hpp"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <memory>
#include <numeric>
#include <optional>

#include "host/io/values/header_text.hpp"
#include "host/io/values/place.hpp"

namespace pxpl5::host::io {

namespace {

namespace fs = std::filesystem;

using Page = PicturePages::Page;

std::optional<Component> component_of(OIIO::TypeDesc type) {
    switch (type.basetype) {
        case OIIO::TypeDesc::UINT8:
            return Component::uint8;
        case OIIO::TypeDesc::INT8:
            return Component::int8;
        case OIIO::TypeDesc::UINT16:
            return Component::uint16;
        case OIIO::TypeDesc::INT16:
            return Component::int16;
        case OIIO::TypeDesc::UINT32:
            return Component::uint32;
        case OIIO::TypeDesc::INT32:
            return Component::int32;
        case OIIO::TypeDesc::HALF:
        case OIIO::TypeDesc::FLOAT:
            return Component::float32;
        case OIIO::TypeDesc::DOUBLE:
            return Component::float64;
        default:
            return std::nullopt;
    }
}

OIIO::TypeDesc type_of(Component component) {
    constexpr OIIO::TypeDesc::BASETYPE types[] = {OIIO::TypeDesc::UINT8,  OIIO::TypeDesc::INT8,
                                                  OIIO::TypeDesc::UINT16, OIIO::TypeDesc::INT16,
                                                  OIIO::TypeDesc::UINT32, OIIO::TypeDesc::INT32,
                                                  OIIO::TypeDesc::UINT64, OIIO::TypeDesc::INT64,
                                                  OIIO::TypeDesc::FLOAT,  OIIO::TypeDesc::DOUBLE};
    return types[static_cast<std::size_t>(component)];
}

Page page_of(const std::string& file, const OIIO::ImageSpec& spec) {
    if (spec.nchannels != 1) {
        throw ImportError(fmt::format(
            "{}: has {} channels, a slice has 1 (gray): color and transparency are not read", file,
            spec.nchannels));
    }
    if (spec.width < min_volume_voxels || spec.width > max_volume_voxels ||
        spec.height < min_volume_voxels || spec.height > max_volume_voxels || spec.depth > 1) {
        throw ImportError(fmt::format("{}: is {}x{} pixels, must be {} to {} each way", file,
                                      spec.width, spec.height, min_volume_voxels,
                                      max_volume_voxels));
    }
    const std::optional<Component> component = component_of(spec.format);
    if (!component) {
        throw ImportError(
            fmt::format("{}: pixels are of type {}, which is not read", file, spec.format.c_str()));
    }
    return {spec.width, spec.height, *component};
}

/// An open file, as its pixels were stored: nothing scaled by transparency.
std::unique_ptr<OIIO::ImageInput> opened(const fs::path& path) {
    OIIO::ImageSpec config;
    config.attribute("oiio:UnassociatedAlpha", 1);
    auto input = OIIO::ImageInput::open(path.string(), &config);
    if (!input) {
        std::string reason = OIIO::geterror();
        std::replace(reason.begin(), reason.end(), '\n', ' ');
        throw ImportError(
            fmt::format("{}: {}", path.string(), reason.empty() ? "is no picture" : shown(reason)));
    }
    return input;
}

/// Counts pages and checks that all are alike. `page` is that of the files before.
int count_pages(const fs::path& path, std::optional<Page>& page) {
    const auto input = opened(path);
    int pages = 0;
    while (pages < static_cast<int>(max_pages) + 1 && input->seek_subimage(pages, 0)) {
        const Page next = page_of(path.string(), input->spec());
        if (page && next != *page) {
            throw ImportError(fmt::format(
                "{}: page {} is {}x{} of {}, those before are {}x{} of {}", path.string(),
                pages + 1, next.columns, next.rows, component_name(next.component), page->columns,
                page->rows, component_name(page->component)));
        }
        page = next;
        ++pages;
    }
    return pages;
}

[[noreturn]] void refuse_change(const fs::path& path, const std::string& change) {
    throw ImportError(
        fmt::format("{}: {}: the file has changed while it was read. Read the file again when it "
                    "is complete",
                    path.string(), change));
}

}  // namespace

PicturePages::PicturePages(const std::string& source, const std::vector<fs::path>& files) {
    std::optional<Page> page;
    for (const fs::path& file : files) {
        files_.push_back({file, count_pages(file, page)});
        if (count() > max_pages) {
            throw ImportError(fmt::format("{}: has more than {} pages", source, max_pages));
        }
    }
    if (!page) {
        throw ImportError(source + ": has no page");
    }
    page_ = *page;
}

std::size_t PicturePages::count() const {
    return std::accumulate(files_.begin(), files_.end(), std::size_t{0},
                           [](std::size_t sum, const File& file) {
                               return sum + static_cast<std::size_t>(file.pages);
                           });
}

void PicturePages::read(ValueSink& sink) const {
    for (const File& file : files_) {
        read_file(file, sink);
    }
}

void PicturePages::read_file(const File& file, ValueSink& sink) const {
    const auto input = opened(file.path);
    std::vector<std::byte> values(static_cast<std::size_t>(page_.columns) *
                                  static_cast<std::size_t>(page_.rows) *
                                  component_bytes(page_.component));
    int index = 0;
    for (; input->seek_subimage(index, 0); ++index) {
        if (index == file.pages) {
            refuse_change(file.path, fmt::format("has more pages than before, {}", file.pages));
        }
        const Page now = page_of(file.path.string(), input->spec());
        if (now != page_) {
            refuse_change(file.path,
                          fmt::format("page {} is {}x{} of {}, was {}x{} of {}", index + 1,
                                      now.columns, now.rows, component_name(now.component),
                                      page_.columns, page_.rows, component_name(page_.component)));
        }
        if (!input->read_image(index, 0, 0, 1, type_of(page_.component), values.data())) {
            std::string reason = input->geterror();
            std::replace(reason.begin(), reason.end(), '\n', ' ');
            throw ImportError(fmt::format("{}: page {} cannot be read: {}", file.path.string(),
                                          index + 1, shown(reason)));
        }
        sink.add(values, page_.component);
    }
    if (index < file.pages) {
        refuse_change(file.path,
                      fmt::format("has fewer pages than before, {} of {}", index, file.pages));
    }
}

std::string picture_kind(const fs::path& path) {
    const std::string suffix = lower_case(path.extension().string());
    return suffix == ".png"                        ? "PNG"
           : suffix == ".tif" || suffix == ".tiff" ? "TIFF"
           : suffix == ".jpg" || suffix == ".jpeg" ? "JPEG"
           : suffix == ".bmp"                      ? "BMP"
                                                   : "";
}

bool is_picture(const fs::path& path) {
    return !picture_kind(path).empty();
}

void keep_one_kind(std::vector<fs::path>& pictures) {
    const auto rank = [](const fs::path& file) {
        const std::string kind = picture_kind(file);
        return kind == "JPEG" ? 2 : kind == "BMP" ? 1 : 0;
    };
    if (!pictures.empty()) {
        const int best = rank(*std::ranges::min_element(pictures, {}, rank));
        std::erase_if(pictures, [&](const fs::path& file) { return rank(file) != best; });
    }
}

bool is_naturally_before(const std::string& a, const std::string& b) {
    const auto is_digit = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; };
    std::size_t i = 0, j = 0;
    while (i < a.size() && j < b.size()) {
        if (!is_digit(a[i]) || !is_digit(b[j])) {
            if (a[i] != b[j]) {
                return a[i] < b[j];
            }
            ++i;
            ++j;
            continue;
        }
        const auto run = [&](const std::string& text, std::size_t& at) {
            const std::size_t begin = std::min(text.find_first_not_of('0', at), text.size());
            at = begin;
            while (at < text.size() && is_digit(text[at])) {
                ++at;
            }
            return text.substr(begin, at - begin);
        };
        const std::string left = run(a, i), right = run(b, j);
        if (left != right) {
            return left.size() != right.size() ? left.size() < right.size() : left < right;
        }
    }
    return i == a.size() && j == b.size() ? a < b : i == a.size();
}

Volume read_pictures(const std::string& source, const std::vector<fs::path>& files,
                     const ImportRequest& request) {
    if (!request.spacing_mm) {
        throw ImportError(source +
                          ": pictures state no distances: give spacing=x,y,z in millimeters");
    }
    OIIO::attribute("threads", 1);
    const PicturePages pages(source, files);
    const Page& page = pages.page();
    Volume volume;
    volume.nx = page.columns;
    volume.ny = page.rows;
    volume.nz = static_cast<int>(pages.count());
    const std::size_t values =
        static_cast<std::size_t>(volume.nx) * static_cast<std::size_t>(volume.ny) * pages.count();
    check_volume_bytes(source,
                       fmt::format("{}x{}x{} of {}", volume.nx, volume.ny, volume.nz,
                                   component_name(page.component)),
                       values * component_bytes(page.component));
    for (int axis = 0; axis < 3; ++axis) {
        volume.voxel_to_patient[axis] *= (*request.spacing_mm)[axis];
    }
    take_directions(source, request,
                    "pictures state no patient space: columns are taken as left, rows as "
                    "posterior, slices as superior, at the distances asked for",
                    volume);
    const auto lossy = std::ranges::count_if(
        files, [](const fs::path& file) { return picture_kind(file) == "JPEG"; });
    if (lossy > 0) {
        volume.findings.push_back(
            {FindingKind::note, fmt::format("{} of {} pictures were compressed with loss (JPEG): "
                                            "their values are not exact",
                                            lossy, files.size())});
    }
    ValueSink sink(values);
    pages.read(sink);
    sink.finish(source, volume);
    return volume;
}

}  // namespace pxpl5::host::io
