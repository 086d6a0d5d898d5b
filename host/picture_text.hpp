// Texts and fingerprints that go with pictures and volumes.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <string>

#include "host/reply.hpp"
#include "host/session.hpp"

namespace pxpl5::host {

/// What a picture's metadata say: volume, spacing, isovalues, view; or the scene's file and view.
std::string picture_text(const Session& session);

/// What `load` and `info` say of an archive.
Reply describe_archive(const phigs::Content& content);

/// Digest of the picture's pixels.
std::uint64_t picture_digest(const Picture& picture);

/// Distance between voxel centres along x, y and z in millimetres.
glm::dvec3 spacing_mm(const Volume& volume);

/// Where the volume's axes point in the patient, nearest first letter per axis: "LPS", "RAS", ...
std::string orientation_letters(const Volume& volume);

}  // namespace pxpl5::host
