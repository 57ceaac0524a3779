# Of C++ sources as clang-format leaves them: "FILE:LINE<tab>SIGNATURE" for each line of a function or type that begins
# in the first column. Files are named by their last two parts.
FNR == 1 {
    n = split(FILENAME, parts, "/")
    file = parts[n - 1] "/" parts[n]
    signature = ""
    inside = 0
}
inside {
    print file ":" FNR "\t" signature
    if ($0 ~ /^}/) { inside = 0; signature = "" }
    next
}
/^[A-Za-z_]/ || (signature != "" && /^ /) {
    signature = signature " " $0
    if ($0 ~ /[;}]$/ || signature ~ /^ (namespace|using|template <.*>$)/) { if (signature !~ /^ template/) signature = "" }
    else if ($0 ~ /\{$/) { inside = 1; print file ":" FNR "\t" signature }
    next
}
{ signature = "" }
