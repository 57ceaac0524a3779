#include "sim/base/base64.h"

#include <openssl/evp.h>

namespace sim {

std::string base64(std::string_view bytes) {
    std::string text(EVP_ENCODE_LENGTH(bytes.size()), '\0'); // with room for the zero that ends it
    const int length = EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()),
                                       reinterpret_cast<const unsigned char*>(bytes.data()), static_cast<int>(bytes.size()));
    text.resize(static_cast<std::size_t>(length));
    return text;
}

std::optional<std::string> bytes_of_base64(std::string_view text) {
    const std::size_t padding = text.ends_with("==") ? 2 : text.ends_with("=") ? 1 : 0;
    // It would pass over white space, and take padding anywhere.
    if (text.size() % 4 != 0 || text.substr(0, text.size() - padding).find_first_of("= \t\r\n") != std::string_view::npos) {
        return {};
    }
    std::string bytes(text.size() / 4 * 3, '\0');
    if (EVP_DecodeBlock(reinterpret_cast<unsigned char*>(bytes.data()), reinterpret_cast<const unsigned char*>(text.data()),
                        static_cast<int>(text.size())) != static_cast<int>(bytes.size())) {
        return {};
    }
    bytes.resize(bytes.size() - padding);
    return bytes;
}

} // namespace sim
