// OpenFOAM 1912 computes digests of dictionaries by a stream buffer that takes whole texts, but no single characters.
// Since GCC 12 the C++ library writes a character as such, and what was compiled with it (Debian 13's package) refuses
// every function object: error in IOstream "sha1". Preloaded into OpenFOAM's programs, this writes it as a text of one
// character, as before.
#include <ostream>

std::ostream& put(std::ostream& stream, char c) __asm__("_ZNSo3putEc"); // std::ostream::put(char)

std::ostream& put(std::ostream& stream, char c)
{
    return stream.write(&c, 1);
}
