#include "host/serve/server/frame_encodings.hpp"

#include <fmt/format.h>

#include "host/base/kernel/standard_streams.hpp"
#include "host/serve/depths/lean_packing.hpp"
#include "host/serve/encoding/reduce.hpp"

namespace pxpl5::host::serve {
namespace {

Shown flat(const Shown& shown) {
    Shown one = shown;
    one.depths = {};
    if (shown.as_one) {
        OnePicture picture = shown.as_one();
        one.width = picture.width;
        one.height = picture.height;
        one.pixels = std::move(picture.pixels);
        one.views = one.layers = 1;
        one.opacity = 0;
        one.as_one = {};
    }
    return one;
}

Shown smaller(Shown shown, double scale) {
    const Size from{shown.width, shown.height};
    const Size to = moving_size(from, scale / shown.scale);
    shown.width = to.width;
    shown.height = to.height;
    shown.scale = scale;
    shown.pixels = reduced_pixels(shown.pixels, from, to, shown.pictures());
    if (!shown.depths.empty()) {
        shown.depths = reduced_depths(shown.depths, from, to, shown.pictures());
    }
    return shown;
}

}  // namespace

void FrameEncodings::begin(const NewestFrame& frame) {
    if (sequence_ == frame.sequence) {
        return;
    }
    sequence_ = frame.sequence;
    forms_.clear();
    pictures_.clear();
    std::erase_if(depths_, [place = frame.shown.depths.data()](const auto& packed) {
        return packed.first != place;
    });
}

const Shown& FrameEncodings::form_of(const Shown& shown, bool with_depths, double scale) {
    const bool is_smaller = !shown.rests && !shown.fixed_size && scale < shown.scale;
    const bool is_flat = !with_depths && (shown.as_one || !shown.depths.empty());
    if (!is_smaller && !is_flat) {
        return shown;
    }
    auto& [words, form] = forms_[{shown.pixels.data(), is_flat, is_smaller ? scale : shown.scale}];
    if (words.empty()) {
        words = shown.pixels;
        form = is_flat ? flat(shown) : shown;
        form = is_smaller ? smaller(std::move(form), scale) : std::move(form);
    }
    return form;
}

const std::string& FrameEncodings::pictures(const Shown& form,
                                            const std::optional<JpegQuality>& quality) {
    auto& [words, bytes] = pictures_[{form.pixels.data(), quality}];
    if (words.empty()) {
        words = form.pixels;
        const int height = form.pictures() * form.height;
        bytes = quality ? jpeg_of(form.width, height, form.pixels, *quality)
                        : png_of(form.width, height, form.pixels);
    }
    return bytes;
}

const std::string& FrameEncodings::depths(const Shown& form) {
    auto& [words, packed] = depths_[form.depths.data()];
    if (words.empty()) {
        words = form.depths;
        try {
            packed = packed_stack(form.width, form.height, form.pictures(), form.depths);
        } catch (const std::exception& error) {  // A picture without depths is better than none.
            print_notice("warning", fmt::format("pictures have no depths: {}", error.what()));
        }
    }
    return packed;
}

}  // namespace pxpl5::host::serve
