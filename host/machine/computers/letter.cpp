#include "host/machine/computers/letter.hpp"

#include <fmt/core.h>

namespace pxpl5::host {

join::LetterT unpacked_letter(std::span<const std::uint8_t> bytes) {
    flatbuffers::Verifier verifier(bytes.data(), bytes.size());
    if (bytes.size() < sizeof(flatbuffers::uoffset_t) || !join::VerifyLetterBuffer(verifier)) {
        throw BadLetter(fmt::format("{} bytes are no letter of pxpl5 join", bytes.size()));
    }
    join::LetterT letter;
    join::GetLetter(bytes.data())->UnPackTo(&letter);
    return letter;
}

}  // namespace pxpl5::host
