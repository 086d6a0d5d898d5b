// Texts and fingerprints that go with pictures.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "host/base/reply.hpp"
#include "host/session/session.hpp"

namespace pxpl5::host {

/// How a file has the pictures of two eyes.
enum class EyesInFile : std::uint8_t {
    composed,  ///< One picture, composed by the scene's stereo mode.
    apart      ///< Two pictures, the left eye's first.
};

/// Metadata of a picture's file for the scene seen by `camera`: volume, spacing, isovalues and
/// view, or the archive's file and view. Includes the overlay's marks if the overlay is on.
PictureExtras picture_extras(const Session& session, const Camera& camera,
                             EyesInFile eyes = EyesInFile::composed);

/// The surface whose isovalue differs between the pictures of an animation.
struct SweptSurface {
    std::string name;
    double first = 0, last = 0;  ///< Isovalues.
};

/// Volumes of a time series that the pictures of an animation show.
struct ShownVolumes {
    int first = 1, last = 1;
};

/// The differences between the pictures of an animation besides the view.
struct AnimationRange {
    std::optional<SweptSurface> swept;
    std::optional<ShownVolumes> volumes;
};

/// The same for an animation: its marks hold from every side, for all isovalues and volumes.
PictureExtras animation_extras(const Session& session, const AnimationRange& range);

/// The reply of `load` and `info` for an archive.
Reply describe_archive(const ArchiveFacts& content);

/// Digest of the picture's pixels.
std::uint64_t picture_digest(const Picture& picture);

}  // namespace pxpl5::host
