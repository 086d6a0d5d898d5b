// Letters between the host and `pxpl5 join`, as bytes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
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

/// Says the parts of `file`, which is relative to `folder`, in order. Of a long log, only its end.
/// A file that cannot be read, or is not inside the folder, has one part with the error.
void send_content(const std::filesystem::path& folder, const std::string& file,
                  const std::function<void(join::ContentT)>& say);

}  // namespace pxpl5::host
