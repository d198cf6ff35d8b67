"""The physical model: body, forces, scene, start, criterion, measure and random key.

Uses ``_checks``, ``inertia`` and the core, but neither methods nor maps; ``solve`` and all
above it use it.
"""
