"""Digitising by an operator: recordings, answers, control balls."""
