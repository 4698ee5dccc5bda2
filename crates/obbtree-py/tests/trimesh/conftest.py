"""Puts our manager in the place of trimesh's, which needs no FCL then."""

import sys
import types

import trimesh.collision

import obbtree

# The tests skip themselves where there is no such module.
sys.modules.setdefault("fcl", types.ModuleType("fcl"))
trimesh.collision.CollisionManager = obbtree.CollisionManager
