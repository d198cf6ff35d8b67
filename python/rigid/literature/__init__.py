"""Numbers of the literature, each computed again by the library: :func:`rigid.validation`.

``entry`` says what an entry is, and ``numbers.toml`` holds them, each with its source and the
function that computes the number again; the other modules have these functions, and ``validation``
runs them. The package uses public functions of the library; the command line uses the package.
"""
