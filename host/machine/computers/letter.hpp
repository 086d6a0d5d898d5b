// Letters between the host and `pxpl5 join`, as bytes.
#pragma once

#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "join_generated.h"

namespace pxpl5::host {

/// A letter that is no letter of this program.
struct BadLetter : std::runtime_error {
    using std::runtime_error::runtime_error;
};

template <typename ObjectT>
std::vector<std::uint8_t> packed_letter(ObjectT word) {
    join::LetterT letter;
    letter.word.Set(std::move(word));
    flatbuffers::FlatBufferBuilder builder;
    builder.Finish(join::Letter::Pack(builder, &letter), join::LetterIdentifier());
    return {builder.GetBufferPointer(), builder.GetBufferPointer() + builder.GetSize()};
}

/// Throws BadLetter.
join::LetterT unpacked_letter(std::span<const std::uint8_t> bytes);

}  // namespace pxpl5::host
