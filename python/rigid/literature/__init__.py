"""Numbers of the literature, each computed again by the library: :func:`rigid.validation`.

``entry`` says what an entry is; ``asteroids``, ``moons``, ``spin_orbit``, ``earth``,
``free_bodies`` and ``heavy_tops`` hold the entries, each with its source and the function that
computes the number again; ``validation`` runs these functions. The package uses public functions of
the library; the command line uses the package.
"""
