#include "host/serve/server/frame_encodings.hpp"

#include <fmt/format.h>

#include "host/base/kernel/standard_streams.hpp"
#include "host/serve/depths/lean_packing.hpp"
#include "host/serve/encoding/reduce.hpp"

namespace pxpl5::host::serve {
namespace {

Shown flat(const Shown& shown) {
    OnePicture picture = shown.as_one();
    Shown one = shown;
    one.width = picture.width;
    one.height = picture.height;
    one.pixels = std::move(picture.pixels);
    one.depths = {};
    one.views = one.layers = 1;
    one.opacity = 0;
    one.as_one = {};
    return one;
}

Shown smaller(Shown shown, const Size& to, double scale) {
    const Size from{shown.width, shown.height};
    shown.width = to.width;
    shown.height = to.height;
    shown.scale = scale;
    shown.pixels = reduced_pixels(shown.pixels, from, to, shown.pictures());
    if (!shown.depths.empty()) {
        shown.depths = reduced_depths(shown.depths, from, to, shown.pictures());
    }
    return shown;
}

/// The value of the key in the map. It is made if it is not there, and not kept if that fails.
template <typename Map, typename Make>
const auto& made(Map& map, const typename Map::key_type& key, const SharedWords& words,
                 const Make& make) {
    auto found = map.find(key);
    if (found == map.end()) {
        found = map.insert({key, {words, make()}}).first;
    }
    return found->second.made;
}

}  // namespace

void FrameEncodings::begin(const NewestFrame& frame) {
    if (sequence_ == frame.sequence) {
        return;
    }
    sequence_ = frame.sequence;
    flat_.clear();
    smaller_.clear();
    pictures_.clear();
    const Place kept = frame.shown.depths.data();
    const Place kept_layers = frame.layers ? frame.layers->depths.data() : nullptr;
    std::erase_if(depths_, [&](const auto& packed) {
        return packed.first != kept && packed.first != kept_layers;
    });
}

const Shown& FrameEncodings::form_of(const Shown& shown, bool with_depths) {
    if (with_depths || !shown.as_one) {
        return shown;
    }
    return made(flat_, shown.pixels.data(), shown.pixels, [&] { return flat(shown); });
}

const Shown& FrameEncodings::in_size(const Shown& form, double scale) {
    if (form.rests || form.fixed_size || scale >= form.scale) {
        return form;
    }
    const Size from{form.width, form.height}, to = moving_size(from, scale / form.scale);
    if (to == from) {
        return form;
    }
    return made(smaller_, {form.pixels.data(), scale}, form.pixels,
                [&] { return smaller(form, to, scale); });
}

const std::string& FrameEncodings::pictures(const Shown& form,
                                            const std::optional<JpegQuality>& quality) {
    return made(pictures_, {form.pixels.data(), quality}, form.pixels, [&] {
        const int height = form.pictures() * form.height;
        return quality ? jpeg_of(form.width, height, form.pixels, *quality)
                       : png_of(form.width, height, form.pixels);
    });
}

const std::string& FrameEncodings::depths(const Shown& form) {
    return made(depths_, form.depths.data(), form.depths, [&] {
        try {
            return packed_stack(form.width, form.height, form.pictures(), form.depths);
        } catch (const std::exception& error) {  // A picture without depths is better than none.
            print_notice("warning", fmt::format("pictures have no depths: {}", error.what()));
            return std::string();
        }
    });
}

}  // namespace pxpl5::host::serve
