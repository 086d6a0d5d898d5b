// The newest frame in the forms and encodings that viewers need.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "host/base/shared_words.hpp"
#include "host/serve/encoding/encode.hpp"
#include "host/serve/server/server_mail.hpp"

namespace pxpl5::host::serve {

/// Makes each form and each encoding once, when the first viewer needs it. References are valid
/// until the next frame.
class FrameEncodings {
  public:
    /// Forgets what belongs to another frame. Refinements of a picture share its packed depths, and
    /// those of its layers.
    void begin(const NewestFrame& frame);

    /// The frame itself for viewers who take depths, and if it has one picture. Otherwise all its
    /// pictures as one, without depths.
    const Shown& form_of(const Shown& shown, bool with_depths);
    /// The form in the size that a viewer's connection carries: the form itself, or a smaller copy
    /// if it moves, is larger, and need not keep its size.
    ///
    /// scale  Relative to the picture at rest.
    const Shown& in_size(const Shown& form, double scale);

    /// The pictures as a JPEG; no quality: as a PNG.
    const std::string& pictures(const Shown& form, const std::optional<JpegQuality>& quality);
    /// Empty if they cannot be packed, with a warning.
    const std::string& depths(const Shown& form);

  private:
    /// A thing that was made of words, with the words, so that no others come to lie in their
    /// place.
    template <typename Made>
    struct Of {
        SharedWords words;
        Made made;
    };
    using Place = const std::uint32_t*;  ///< Place of the pixels or depths.

    std::uint64_t sequence_ = 0;
    std::map<Place, Of<Shown>> flat_;
    std::map<std::pair<Place, double>, Of<Shown>> smaller_;
    std::map<std::pair<Place, std::optional<JpegQuality>>, Of<std::string>> pictures_;
    std::map<Place, Of<std::string>> depths_;
};

}  // namespace pxpl5::host::serve
