# Of callgrind's output: "FILE:LINE<tab>INSTRUCTIONS", those of called functions not among them. Files are named by their
# last two parts.
function name_of(text, id) {
    id = text
    sub(/\).*/, ")", id)
    if (length(text) > length(id)) { names[id] = substr(text, length(id) + 2) }
    return names[id]
}
/^(fl|fi|fe)=/ {
    n = split(name_of(substr($0, 4)), parts, "/")
    file = parts[n - 1] "/" parts[n]
    next
}
/^(cfi|cfl)=/ { name_of(substr($0, 5)); next }
/^calls=/ { is_call = 1; next }
/^[0-9+*-]/ {
    if ($1 ~ /^[+]/) { line += substr($1, 2) }
    else if ($1 ~ /^-/) { line -= substr($1, 2) }
    else if ($1 != "*") { line = $1 }
    if (is_call) { is_call = 0; next }
    cost[file ":" line] += $2
}
END { for (at in cost) { printf "%s\t%d\n", at, cost[at] } }
