// Where the elements of one frame of a DICOM file are. Only files that include GDCM include this.
#pragma once

#include <gdcmDataSet.h>
#include <gdcmSequenceOfItems.h>

#include <cstring>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "host/io/dicom/dicom_elements.hpp"

namespace pxpl5::host::io {

/// The data sets in which a frame's element may be: the frame's own functional group, the shared
/// one, the file's.
class FrameGroups {
  public:
    FrameGroups(const gdcm::DataSet& file, int frame) : file_(&file) {
        add_group(gdcm::Tag(0x5200, 0x9230), static_cast<std::size_t>(frame) + 1);
        add_group(gdcm::Tag(0x5200, 0x9229), 1);
    }

    /// The first of: element `tag` in sequence `macro` of the groups, `tag` in the file.
    std::vector<double> numbers(const std::string& name, gdcm::Tag macro, gdcm::Tag tag) const {
        return first_of(macro,
                        [&](const gdcm::DataSet& set) { return numbers_of(name, set, tag); });
    }

    /// The same as numbers(), but as text.
    std::string text(gdcm::Tag macro, gdcm::Tag tag) const {
        return first_of(macro, [&](const gdcm::DataSet& set) { return text_of(set, tag); });
    }

    /// The same as numbers(), but as bytes.
    std::string bytes(gdcm::Tag macro, gdcm::Tag tag) const {
        return first_of(macro, [&](const gdcm::DataSet& set) { return bytes_of(set, tag); });
    }

    /// A binary number (US, UL or FD). No value if it is absent or of another size.
    template <typename T>
    std::optional<T> binary(gdcm::Tag macro, gdcm::Tag tag) const {
        const std::string found = bytes(macro, tag);
        T value{};
        if (found.size() != sizeof value) {
            return std::nullopt;
        }
        std::memcpy(&value, found.data(), sizeof value);
        return value;
    }

    bool has(gdcm::Tag macro) const { return !groups_of(macro).empty(); }

  private:
    using Items = gdcm::SmartPointer<gdcm::SequenceOfItems>;

    /// Returns the result of `read` for the first data set in which it is not empty.
    template <typename Read>
    std::invoke_result_t<Read, const gdcm::DataSet&> first_of(gdcm::Tag macro,
                                                              const Read& read) const {
        for (const Items& group : groups_of(macro)) {
            auto found = read(group->GetItem(1).GetNestedDataSet());
            if (!found.empty()) {
                return found;
            }
        }
        return read(*file_);
    }

    void add_group(gdcm::Tag tag, std::size_t item) {
        if (!file_->FindDataElement(tag)) {
            return;
        }
        const Items items = file_->GetDataElement(tag).GetValueAsSQ();
        if (items != nullptr && items->GetNumberOfItems() >= item) {
            groups_.push_back({items, item});
        }
    }

    std::vector<Items> groups_of(gdcm::Tag macro) const {
        std::vector<Items> found;
        for (const auto& [items, item] : groups_) {
            const gdcm::DataSet& group = items->GetItem(item).GetNestedDataSet();
            if (group.FindDataElement(macro)) {
                const Items inner = group.GetDataElement(macro).GetValueAsSQ();
                if (inner != nullptr && inner->GetNumberOfItems() > 0) {
                    found.push_back(inner);
                }
            }
        }
        return found;
    }

    const gdcm::DataSet* file_;
    std::vector<std::pair<Items, std::size_t>> groups_;
};

/// Reads the elements that tell a frame from others of its place. An element with an invalid value
/// is treated as missing.
DicomTimes read_times(const gdcm::DataSet& data, const FrameGroups& groups);

}  // namespace pxpl5::host::io
