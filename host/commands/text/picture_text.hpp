// Texts and fingerprints that go with pictures.
#pragma once

#include <cstdint>
#include <string>

#include "host/base/reply.hpp"
#include "host/session/session.hpp"

namespace pxpl5::host {

/// What a picture's file says of the scene as `camera` sees it: volume, spacing, isovalues, view;
/// or the archive's file and view. With the overlay's marks, if it is on.
PictureExtras picture_extras(const Session& session, const Camera& camera);

/// The same for an animation around the volume: its marks hold from every side.
PictureExtras animation_extras(const Session& session);

/// What `load` and `info` say of an archive.
Reply describe_archive(const phigs::Content& content);

/// Digest of the picture's pixels.
std::uint64_t picture_digest(const Picture& picture);

}  // namespace pxpl5::host
