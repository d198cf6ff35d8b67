"""The physical model: body, torque and damping, scene, start, criterion and random key.

Uses ``_checks``, ``inertia`` and the core, but neither methods nor maps; ``solve`` and all
above it use it.
"""
